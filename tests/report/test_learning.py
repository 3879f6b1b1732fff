"""Learning curves with the levels of other schedules."""

import json
from pathlib import Path

import pytest

from sensorless.agents.train.curve import COLUMNS
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.validation import validate
from sensorless.machine.motor import Motor
from sensorless.policies import shipped
from sensorless.policies.registry import make_policy
from sensorless.report.learning import curves_of, learning, levels_of, shipped_levels

HEAD = ",".join(COLUMNS) + "\n"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run folder that validates on few scenarios."""
    config = json.loads((shipped.FOLDER / "flux" / "config.json").read_text(encoding="utf-8"))
    config["train"]["validate_size"] = 16
    (tmp_path / "config.json").write_text(json.dumps(config))
    return tmp_path


def test_levels_are_validated_like_the_run(run: Path) -> None:
    motor = Motor.load("paper")
    found = levels_of(run, ["linear-tuned", "eq25"])
    config = json.loads((run / "config.json").read_text())
    factory = SimFactory(motor, DriveDesign(estimator=config["design"]["estimator"]))
    assert factory.design.estimator == "flux"
    assert found == {w: validate(make_policy(w, motor), factory, 16) for w in found}
    with pytest.raises(UserError, match="nobody"):
        levels_of(run, ["nobody"])


def test_the_shipped_levels_are_those_of_the_same_motor(run: Path, tmp_path: Path) -> None:
    assert list(shipped_levels(run)) == ["flux_observer-tuned", "reference"]
    config = json.loads((run / "config.json").read_text())
    other = Motor.load("ipmsm_2200w")
    config |= {"motor_digest": other.digest, **record(DriveDesign(estimator="smo"), other)}
    (run / "config.json").write_text(json.dumps(config))
    assert list(shipped_levels(run)) == ["linear-tuned"]
    assert shipped_levels(run / "no-run") == {}


def test_the_panels_have_the_run_the_levels_and_what_was_kept(run: Path) -> None:
    rows = (
        HEAD + "0,0,0.1,0.06,0.02,1.08,1\n5,60,0.02,0.05,0.01,0.26,1\n9,120,0.01,0.05,0.02,0.17,0\n"
    )
    (run / "progress.csv").write_text(rows)
    panels, said = learning(str(run))
    assert [p["label"].split(" [")[0] for p in panels][:2] == ["objective", "lost in validation"]
    curves = {c["name"]: c["values"] for c in panels[1]["curves"]}
    assert panels[1]["x"] == [0.0, 1.0, 2.0]
    assert curves[run.name] == pytest.approx([10.0, 2.0, 1.0])
    assert curves[f"{run.name}, kept"] == [None, pytest.approx(2.0), None]
    levels = shipped_levels(run)
    assert levels and all(name in said for name in levels)
    for name, cost in levels.items():
        assert curves[name] == [100.0 * cost.lost_rate] * 3
    assert learning(str(run / "none")) == ([], "")


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("config.json", "[]", r"config\.json: \[\] has no fields"),
        ("config.json", "{", r"config\.json: .*restore"),
        ("config.json", "{}", r"config\.json: train: missing"),
        ("config.json", '{"train": {}}', r"config\.json: train: motor: missing"),
        ("config.json", '{"train": {"motor": 3}}', r"config\.json: train: motor: 3"),
        ("config.json", '{"train": {"motor": "paper"}}', "train: validate_size: missing"),
        (
            "progress.csv",
            f"{HEAD}0,many,1,1,1,1,1\n",
            "line 2: seconds: 'many' is no finite",
        ),
        ("progress.csv", f"{HEAD}0,1,1,1,1,1,1\n3\n", "line 3: 1 values, not 7"),
        ("progress.csv", "seconds\n0\n", r"progress\.csv: line 1: .*not the columns"),
    ],
)
def test_a_damaged_file_is_named(name: str, text: str, said: str, run: Path) -> None:
    (run / "progress.csv").write_text(f"{HEAD}0,0,1,1,1,1,1\n")
    (run / name).write_text(text)
    with pytest.raises(UserError, match=said):
        learning(str(run))


def test_curves_of_a_folder_of_runs_and_of_one(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "progress.csv").write_text(f"{HEAD}0,0,1,1,1,0.5,1\n10,9,1,1,1,0.25,1\n")
    (tmp_path / "progress.csv").write_text(f"{HEAD}0,0,1,1,1,0.5,1\n")
    assert list(curves_of(tmp_path)) == ["a", "b"]
    assert list(curves_of(tmp_path, alone=True)) == [tmp_path.name]
    assert curves_of(tmp_path / "a")["a"]["objective"].tolist() == [0.5, 0.25]
    assert curves_of(tmp_path / "none") == {}

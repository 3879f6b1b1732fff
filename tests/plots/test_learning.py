"""Learning curves with the levels of other schedules."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from sensorless.agents.validation import validate
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.objective import Cost
from sensorless.machine.motor import Motor
from sensorless.plots.learning import curves_of, learning_curves, levels_of, shipped_levels
from sensorless.policies import shipped
from sensorless.policies.registry import make_policy

CURVE = {
    "seconds": np.array([0.0, 60.0, 120.0]),
    "lost_rate": np.array([0.1, 0.05, 0.02]),
    "torque_dev": np.array([0.06, 0.05, 0.05]),
    "torque_ripple": np.array([0.02, 0.01, 0.01]),
    "objective": np.array([1.08, 0.56, 0.26]),
}


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
    config |= record(DriveDesign(estimator="smo"), Motor.load("ipmsm_2200w"))
    (run / "config.json").write_text(json.dumps(config))
    assert list(shipped_levels(run)) == ["linear-tuned"]
    assert shipped_levels(run / "no-run") == {}


def test_levels_are_lines_across_every_part() -> None:
    levels = {"rule": Cost(0.03, 0.055, 0.015), "reference": Cost(0.0, 0.06, 0.013)}
    figure = learning_curves({"seed-1": CURVE}, levels)
    heights = [[100.0 * c.objective for c in levels.values()], [3.0, 0.0], [5.5, 6.0], [1.5, 1.3]]
    for ax, wanted in zip(figure.axes, heights, strict=True):
        flat = {str(x.get_label()): np.asarray(x.get_ydata()) for x in ax.lines}
        for name, y in zip(levels, wanted, strict=True):
            np.testing.assert_allclose(flat[name], y)
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [t.get_text() for t in legend.get_texts()] == ["seed-1", "rule", "reference"]


def test_curves_of_a_folder_of_runs_and_of_one(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "progress.csv").write_text("steps,objective\n0,0.5\n10,0.25\n")
    (tmp_path / "progress.csv").write_text("steps,objective\n0,0.5\n")
    assert list(curves_of(tmp_path)) == ["a", "b"]
    assert curves_of(tmp_path / "a")["a"]["objective"].tolist() == [0.5, 0.25]
    assert curves_of(tmp_path / "none") == {}

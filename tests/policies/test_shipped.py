"""Tuned rules and the reference run by name."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.baselines.linear import linear_table
from sensorless.core.api import SIGNAL_N
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies import shipped
from sensorless.policies.registry import RULES, known, make_policy
from sensorless.policies.tuned import Tuned

PAPER = Motor.load("paper")
RESULTS = Path(__file__).parents[2] / "results" / "reference"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What ``results/reference`` may hold."""
    (tmp_path / "tuned").mkdir()
    tuned = Tuned("linear", {"lo": 0.1, "hi": 0.5}, {"budget_s": 600.0})
    tuned.save(tmp_path / "tuned" / "linear-tuned.json")
    linear_table(0.1, 0.3).save(tmp_path / "table.json", {"motor_digest": PAPER.digest})
    monkeypatch.setattr(shipped, "FOLDER", tmp_path)
    return tmp_path


def weight(spec: str, speed: float) -> float:
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    obs[0, 0] = speed
    return float(make_policy(spec, PAPER).act(obs)[0])


def test_a_tuned_rule_by_its_name(folder: Path) -> None:
    assert make_policy("linear-tuned", PAPER).name == "linear-tuned"
    assert weight("linear-tuned", 0.3) == pytest.approx(0.5)
    assert weight("linear", 0.3) == 0.0


def test_the_reference_run_by_its_name(folder: Path) -> None:
    assert make_policy("reference", PAPER).name == "reference"
    assert weight("reference", 0.2) == pytest.approx(0.5)


def test_both_are_on_the_list(folder: Path) -> None:
    lines = known()
    assert lines["linear-tuned"].endswith("in 600 s simulated, estimator=smo"), "names none"
    provenance = {"budget_s": 600.0, "design": {"estimator": "flux"}}
    Tuned("linear", {"lo": 0.1, "hi": 0.5}, provenance).save(folder / "tuned/flux-tuned.json")
    assert known()["flux-tuned"].endswith("in 600 s simulated, estimator=flux")
    Tuned("error_blend", {"lo": 0.1, "hi": 0.5}, provenance).save(folder / "tuned/own-tuned.json")
    assert known()["own-tuned"].endswith("estimator=errors"), "the rule brings its own"
    assert "PPO" in lines["reference"]
    assert all(len(doc) < 90 for doc in lines.values())


def test_a_rule_that_nobody_tuned_yet(folder: Path) -> None:
    with pytest.raises(UserError) as caught:
        make_policy("gated-tuned", PAPER)
    text = str(caught.value)
    assert "results/reference/tuned/gated-tuned.json" in text
    assert "sensorless tune gated" in text and "linear-tuned" in text and "\n" not in text


@pytest.mark.parametrize("spec", ["linear-tuned:1,2", "nobody-tuned", "../table-tuned"])
def test_names_that_are_none(folder: Path, spec: str) -> None:
    with pytest.raises(UserError, match=r"choose from|there is no folder '\.\./table-tuned'"):
        make_policy(spec, PAPER)


def test_nothing_shipped_is_no_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shipped, "FOLDER", tmp_path / "none")
    assert "reference" not in known()
    with pytest.raises(UserError, match="is not a rule, folder or file"):
        make_policy("reference", PAPER)


def test_the_package_ships_the_folder_of_the_repository() -> None:
    assert shipped.FOLDER.resolve() == RESULTS
    for name in shipped.tuned_names():
        assert Tuned.load(shipped.tuned_file(name)).rule in RULES
        assert make_policy(name, PAPER).name == name


@pytest.mark.parametrize(
    ("name", "estimator"),
    [
        ("reference", "coupled"),
        ("reference-flux", "flux"),
        ("logistic-coupled-tuned", "coupled"),
        ("logistic-flux-tuned", "flux"),
        ("logistic-tuned", "smo"),
        ("linear-tuned", "smo"),
    ],
)
def test_what_is_shipped_runs_on_the_estimator_it_was_made_on(name: str, estimator: str) -> None:
    assert make_policy(name, PAPER).settings["estimator"] == estimator


def test_what_names_no_estimator_runs_on_the_sliding_mode_observer(folder: Path) -> None:
    assert make_policy("linear-tuned", PAPER).settings["estimator"] == "smo"
    assert make_policy("reference", PAPER).settings["estimator"] == "smo"


def test_what_the_learning_study_ships_goes_by_its_name(folder: Path) -> None:
    (folder / "learned").mkdir()
    linear_table(0.1, 0.3).save(
        folder / "learned/ppo-smo-gains.json", {"motor_digest": PAPER.digest}
    )
    Tuned("linear", {"lo": 0.1, "hi": 0.5}, {}).save(folder / "learned/tuned-smo-gains.json")
    assert make_policy("ppo-smo-gains", PAPER).name == "ppo-smo-gains"
    assert weight("ppo-smo-gains", 0.2) == pytest.approx(0.5)
    assert weight("tuned-smo-gains", 0.3) == pytest.approx(0.5)
    lines = known()
    assert "gains on the smo drive by PPO" in lines["ppo-smo-gains"]
    assert "CMA-ES on a rule" in lines["tuned-smo-gains"]
    assert all(len(doc) < 90 for doc in lines.values())


@pytest.mark.parametrize("name", sorted(shipped.ALIASES))
def test_a_second_name_is_the_same_policy(name: str) -> None:
    policy, other = make_policy(name, PAPER), make_policy(shipped.ALIASES[name], PAPER)
    assert policy.name == name and policy.settings == other.settings
    obs = np.random.default_rng(1).uniform(0.0, 0.5, (50, SIGNAL_N)).astype(np.float32)
    assert np.array_equal(policy.act(obs), other.act(obs))

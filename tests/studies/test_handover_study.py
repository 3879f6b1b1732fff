"""The study of the hand-over window: what is paired with what, and the search for a quiet one."""

from types import ModuleType

import numpy as np
import pytest

from sensorless.baselines.logistic import RULE
from sensorless.design.drive import DriveDesign
from sensorless.evaluation.evaluate import Scores
from sensorless.machine.motor import Motor
from tests.helpers.scenarios import lasting
from tests.helpers.script import script

MOTOR = Motor.load("paper")


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return script("studies/handover_study.py")


def scores(study: ModuleType, lost: list[int], ripple: list[float]) -> Scores:
    metrics = {name: np.ones(len(lost)) for name in study.COLUMNS}
    metrics["torque_ripple_window"] = np.array(ripple)
    return Scores(np.array(lost, dtype=np.int32), np.ones(len(lost)), metrics, {}, {})


def test_a_policy_is_paired_with_eq25_on_both_drives(study: ModuleType) -> None:
    table = {
        ("corrected", "eq25"): scores(study, [0, 0, 0], [0.02, 0.02, 0.08]),
        ("published", "eq25"): scores(study, [0, 0, 1], [0.05, 0.05, 9.0]),
        ("corrected", "mine"): scores(study, [0, 0, 0], [0.01, 0.03, 0.05]),
    }
    found = study.compare("corrected", table, "mine", 1)
    assert found["torque_ripple_window"] == pytest.approx(0.03)
    own, paper = found["to corrected eq25"], found["to published eq25"]
    assert (own["survived_both"], paper["survived_both"]) == (3, 2)
    assert own["torque_ripple_window"] == pytest.approx(-0.01)
    assert paper["torque_ripple_window"] == pytest.approx(-0.03)
    assert paper["there"]["torque_ripple_window"] == pytest.approx(0.05)


def test_the_search_stays_in_its_ranges_and_repeats(
    study: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "SEARCHED", 4)
    monkeypatch.setattr(study, "suite", lasting(1.7))
    found = [study.quietest(MOTOR, DriveDesign(), 1, 1) for _ in range(2)]
    assert found[0] == found[1]
    assert found[0] != RULE.defaults()
    for p in RULE.parameters:
        assert p.search[0] <= found[0][p.name] <= p.search[1]

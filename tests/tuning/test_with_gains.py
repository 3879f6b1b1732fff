"""The logistic rule with gains of the drive."""

import numpy as np
import pytest

from sensorless.core.gains import DEFAULT
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.machine.motor import Motor
from sensorless.policies.registry import rule_named
from sensorless.tuning import with_gains
from sensorless.tuning.with_gains import SCHEDULED, table_of, tune_with_gains


def test_a_rule_with_gains_is_linear_over_speed() -> None:
    point = np.full(7 + 2 * 4, 0.5)
    point[7:11] = (0.0, 0.5, 1.0, 1.0)
    ranges = {"l_q": DEFAULT["l_q"], "amplitude": DEFAULT["amplitude"]}
    l_q, amplitude = table_of(point, ranges, SCHEDULED).gains
    column = l_q.values[:, 2, 1]
    assert column[0] == -1.0 and column[-1] == 1.0 and (np.diff(column) >= 0.0).all()
    assert (l_q.values == column[:, None, None]).all()
    assert (amplitude.values == 0.0).all()


def test_tuning_is_repeatable_and_keeps_its_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(with_gains, "CANDIDATE", 1)
    monkeypatch.setattr(with_gains, "JUDGED", 2)
    factory = SimFactory(Motor.load("paper"), DriveDesign(estimator="smo"))
    given = (factory, {"observer": DEFAULT["observer"]}, (0.0,), 20.0, 3, 4.0,
             rule_named("logistic").defaults())  # fmt: skip
    (table, value), (again, other) = tune_with_gains(*given), tune_with_gains(*given)
    assert table.digest == again.digest and value == other
    assert [grid.gain for grid in table.gains] == ["observer"]

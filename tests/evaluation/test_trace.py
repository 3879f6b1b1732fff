"""What a run records of a drive that runs away."""

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import fig9, plan_from
from sensorless.evaluation.trace import outcome, trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy


def test_a_run_ends_where_numbers_overflow() -> None:
    """Far beyond rated speed the current control no longer holds even with an encoder."""
    motor = Motor.load("paper")
    plan = plan_from(fig9(motor), "0:-33", None, 8.0, motor, 1)
    t = trace(make_policy("eq25", motor), plan, motor, DriveDesign(), go_on=True)
    n = len(t["t"])
    assert 0.5 < t["t"][-1] < 7.9
    assert all(len(column) == n for column in t.values())
    assert all(np.isfinite(column).all() for column in t.values())
    assert outcome(t).startswith("not feasible: the drive with an encoder trips or runs away")

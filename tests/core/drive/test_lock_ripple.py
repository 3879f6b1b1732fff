"""A current that swings with the rotor's harmonics is no slip: tests of lost lock look at means."""

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = member(9301, 42)
"""L_q is 6.2 times L_d: a second saliency of 5 % moves its current by an eighth of rated."""


def test_six_swings_a_turn_raise_no_alarm() -> None:
    """With samples in place of means, LOCK_CURRENT told a lost angle in each of these."""
    rows = SuiteRows("stress", MOTOR, 7701, 64).draw()[np.array([8, 9, 22, 30, 46])]
    found = score(make_policy("eq25", MOTOR), rows, SimFactory(MOTOR, DriveDesign()))
    assert not found.lost.any()
    assert np.all(found.lock["false_alarms"] == 0)


@pytest.mark.parametrize("speed", [0.5, 0.7])
def test_harmonics_of_the_emf_raise_no_alarm(speed: float) -> None:
    """5th and 7th of the flux 4 % each, against each other: the current swings six times a turn.

    ``LOCK_CURRENT``, which took the distance without its sign, was on for half the time.
    """
    motor = Motor.load("ipmsm_2200w")
    plan = plan_from(f"0:{speed * motor.n_rated_rpm}", "0:0,0.5:6", None, 2.0, motor, 0)
    plan.emf_5[:], plan.emf_7[:] = 0.2, -0.28
    found = score(make_policy("eq25", motor), plan, SimFactory(motor, DriveDesign()))
    assert not found.lost.any() and found.metrics["angle_err_max_deg"].max() < 20.0
    assert np.all(found.lock["false_alarms"] == 0)

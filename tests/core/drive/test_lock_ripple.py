"""A current that swings with the rotor's harmonics is no slip: tests of lost lock look at means."""

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import score
from sensorless.policies.registry import make_policy

MOTOR = member(9301, 42)
"""L_q is 6.2 times L_d: a second saliency of 5 % moves its current by an eighth of rated."""


def test_six_swings_a_turn_raise_no_alarm() -> None:
    """With samples in place of means, LOCK_CURRENT told a lost angle in each of these."""
    rows = SuiteRows("stress", MOTOR, 7701, 64).draw()[np.array([8, 9, 22, 30, 46])]
    found = score(make_policy("eq25", MOTOR), rows, SimFactory(MOTOR, DriveDesign()))
    assert not found.lost.any()
    assert np.all(found.lock["false_alarms"] == 0)

"""Machines whose rotor turns far in a PWM period: the L_q that the coupled observer takes."""

import numpy as np
import pytest

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import Scores, score
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy

FAST = member(8101, 1)
"""21 PWM periods a turn at rated speed."""


def scores(design: DriveDesign) -> Scores:
    """Three scenarios with an observer's L_q far too low, at rated speed."""
    rows = SuiteRows("stress", FAST, 7701, 64).draw()[np.array([33, 41, 58])]
    return score(make_policy("eq25", FAST), rows, SimFactory(FAST, design))


def test_shipped_machines_keep_the_low_inductance() -> None:
    for path in MOTORS.glob("*.toml"):
        assert derive(Motor.load(path.stem), DriveDesign()).coupled_L_q_bias == 0.85


def test_it_rises_with_the_turn_in_a_period_up_to_the_files() -> None:
    assert FAST.omega_rated * FAST.T_s == pytest.approx(0.3, abs=0.01)
    assert derive(FAST, DriveDesign()).coupled_L_q_bias == 1.0
    slower = member(8101, 8)
    turn = slower.omega_rated * slower.T_s
    assert derive(slower, DriveDesign()).coupled_L_q_bias == 0.85 + 1.25 * (turn - 0.16)


def test_a_low_inductance_swings_there_and_this_one_does_not() -> None:
    """With a low one the current swings against the frame, with the speed of the rotor."""
    low, own = scores(DriveDesign(coupled_L_q_bias=0.85)), scores(DriveDesign())
    assert not low.lost.any() and not own.lost.any()
    ripple = own.metrics["torque_ripple_rms"] / low.metrics["torque_ripple_rms"]
    assert np.all(ripple < 0.6)
    assert np.all(own.lock["false_alarms"] == 0)

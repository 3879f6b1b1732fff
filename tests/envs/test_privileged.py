"""What a critic is told of a scenario, by hand."""

import math

import numpy as np
import pytest

from sensorless.envs.privileged import FIXED, fixed
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor


def told(scenario: Scenarios, motor: Motor) -> dict[str, float]:
    names = (column.name for column in FIXED)
    return dict(zip(names, fixed(scenario, motor)[0].tolist(), strict=True))


@pytest.fixture
def scenario(motor: Motor) -> Scenarios:
    return Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 1.0)


def test_an_ideal_machine_that_is_known_has_nothing_to_tell(
    scenario: Scenarios, motor: Motor
) -> None:
    scenario.dead_time[:], scenario.noise[:] = 0.0, 0.0
    assert told(scenario, motor) == {column.name: 0.0 for column in FIXED}


def test_every_column_is_1_at_its_scale(scenario: Scenarios, motor: Motor) -> None:
    scenario.R_s[0], scenario.L_q_hat[0], scenario.psi_f[0] = 1.25, 1.10, 1.05
    scenario.J[0], scenario.cross_hat[0] = math.e, 1.40
    scenario.dead_time[0], scenario.noise[0] = motor.dead_time, 0.001 * motor.i_rated
    scenario.gain[0] = 1.01, 1.00
    scenario.offset[0] = 0.006 * motor.i_rated, 0.008 * motor.i_rated
    assert told(scenario, motor) == pytest.approx({c.name: 1.0 for c in FIXED}, rel=1e-5)


def test_gains_count_by_how_far_they_are_apart(scenario: Scenarios, motor: Motor) -> None:
    """One per cent up, and one down."""
    scenario.gain[0] = 1.01, 0.99
    assert told(scenario, motor)["gain"] == pytest.approx(2.0, rel=1e-5)

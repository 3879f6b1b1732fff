"""What columns of a log are taken for, on columns that are known: angles, signs, units."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.replay.channels import of_little, of_size
from sensorless.replay.signature import (
    are_percent,
    is_degrees,
    of_encoder,
    of_injection,
    time_scale,
)

MOTOR = Motor.load("paper")
ALL = np.ones(3000, dtype=bool)
TURN = np.linspace(0.0, 40.0, 3000)
"""Way of the rotor, electrical [rad]."""


def encoder(theta: Floats, way: Floats = TURN) -> list[str]:
    """What is said of an encoder beside an estimate that is right, both within a turn."""
    return list(of_encoder(theta % (2.0 * np.pi), way % (2.0 * np.pi), ALL, MOTOR))


@pytest.mark.parametrize(
    ("factor", "cure"),
    [
        (-1.0, "turned round: try --map theta_e=-theta_e"),
        (1.0 / MOTOR.n_p, "mechanical: try --map theta_m=theta_e"),
        (-1.0 / MOTOR.n_p, "mechanical and turned round: try --map theta_m=-theta_e"),
    ],
)
def test_an_encoder_that_counts_otherwise_is_told_with_its_cure(factor: float, cure: str) -> None:
    (said,) = encoder(factor * TURN)
    assert said.endswith(f"if {cure}")


@pytest.mark.parametrize(("degrees", "told"), [(0, False), (28, False), (32, True), (-75, True)])
def test_the_zero_of_an_encoder_is_told_from_30_degrees_on(degrees: int, told: bool) -> None:
    said = encoder(TURN + np.radians(degrees))
    assert len(said) == told
    assert all(f"zero is {degrees} electrical degrees off" in line for line in said)


def test_an_encoder_that_does_not_follow_has_no_zero() -> None:
    """37 degrees to either side of 40: the mean of exp(j error) is cos 37 degrees = 0.8 long."""
    assert encoder(TURN + np.radians(40.0 + 37.0 * np.where(np.arange(3000) % 2, 1, -1))) == []


@pytest.mark.parametrize(("way", "told"), [(6.0, False), (6.6, True)])
def test_a_direction_shows_from_a_turn_on(way: float, told: bool) -> None:
    turn = way / 40.0 * TURN
    assert bool(encoder(-turn, turn)) == told


@pytest.mark.parametrize(
    ("sign", "other", "told"), [(-1.0, 0.3, True), (1.0, 0.3, False), (-1.0, 0.3 + np.pi, False)]
)
def test_the_sign_of_the_injection_needs_two_angles(sign: float, other: float, told: bool) -> None:
    """An encoder that is half a turn off looks alike; then the other angle objects."""
    inj = np.where(np.arange(12) % 2, 1.0, -1.0)
    u = sign * 20.0 * inj[:, None] * (np.cos(0.3), np.sin(0.3))
    said = list(of_injection(u, inj, np.full(12, 0.3), np.full(12, other)))
    assert len(said) == told
    assert all("in 11 of 11 rows" in line and "inj=-inj" in line for line in said)


def test_a_unit_of_time_fits_within_two_percent() -> None:
    t: Floats = np.asarray(MOTOR.T_s * np.arange(50.0))
    assert time_scale(np.asarray(1.01e3 * t), MOTOR.T_s) == (1e-3, "ms")
    assert time_scale(np.asarray(1.03e3 * t), MOTOR.T_s) == (1.0, "s")


def test_an_angle_that_jumps_by_two_turns_is_no_degrees() -> None:
    assert not is_degrees(TURN % (4.0 * np.pi), MOTOR.T_s, 1e5)
    assert is_degrees(np.degrees(TURN) % 360.0, MOTOR.T_s, 1e5)


@pytest.mark.parametrize(
    ("low", "high", "percent"), [(5.0, 95.0, True), (0.05, 0.95, False), (5.0, 150.0, False)]
)
def test_duty_cycles_in_percent(low: float, high: float, percent: bool) -> None:
    assert are_percent(np.linspace(low, high, 300).reshape(-1, 3)) == percent


def test_one_duty_cycle_beyond_the_period_is_no_percent() -> None:
    duties = np.full((100, 3), 0.5)
    duties[40, 1] = 2.0
    assert not are_percent(duties)


@pytest.mark.parametrize(
    ("factor", "said"),
    [(9.5, ""), (10.5, "10.5 times larger"), (1 / 9.5, ""), (1 / 10.5, "10.5 times smaller")],
)
def test_an_answer_ten_times_off_has_another_unit(factor: float, said: str) -> None:
    """i rises by u T_s / L in a period, times the factor."""
    motor = replace(MOTOR, L_d=0.05, L_q=0.05)
    u = np.random.default_rng(1).normal(0.0, 30.0, (400, 2))
    i = factor * np.cumsum(u, axis=0) * motor.T_s / 0.05
    told = list(of_size(u, i, motor))
    assert len(told) == (said != "") and all(said in line for line in told)


@pytest.mark.parametrize(("share", "told"), [(0.009, True), (0.011, False)])
def test_currents_below_a_hundredth_of_rated_may_have_another_unit(
    share: float, told: bool
) -> None:
    i = share * MOTOR.i_rated * np.array([[0.2, -1.0], [0.5, 0.3]])
    assert bool(list(of_little(i, MOTOR))) == told

"""Numbers of the coupled observer that follow from the machine."""

import math
from dataclasses import replace

import pytest

from sensorless.design.derived import LOOP_SHARE, derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.coupled_design import DAMPING, LEAN, RISE_OVER_LOAD, damping
from sensorless.observers.flux_design import standstill_rate

NAMES = sorted(path.stem for path in MOTORS.glob("*.toml"))


def lean(motor: Motor, zeta: float) -> float:
    """Angle error at a fifth of rated speed and rated current, R_s a third too large [rad]."""
    omega = 0.2 * motor.omega_rated
    drift = motor.R_s / 3.0 * motor.i_rated / motor.psi_f
    return 2.0 * (standstill_rate(motor) + zeta * omega) * drift / omega**2


@pytest.mark.parametrize("name", NAMES)
def test_a_wrong_resistance_leans_the_angle_little(name: str) -> None:
    motor = Motor.load(name)
    zeta = damping(motor)
    least, most = DAMPING
    assert lean(motor, zeta) <= LEAN or zeta == least
    assert lean(motor, zeta) == pytest.approx(LEAN) or zeta in (least, most)


def test_damping_falls_with_the_resistance() -> None:
    """Less on the wheel machine, whose resistance takes most of the voltage at the hand-over."""
    motor = Motor.load("formula_wheel")
    stiff = replace(motor, R_s=0.9 * motor.R_s)
    assert DAMPING[0] < damping(stiff) < DAMPING[1]
    assert lean(stiff, damping(stiff)) == pytest.approx(LEAN)


def test_damping_stays_within_its_bounds(motor: Motor) -> None:
    assert damping(replace(motor, R_s=100.0 * motor.R_s)) == DAMPING[0]


@pytest.mark.parametrize("name", NAMES)
def test_the_rise_is_as_fast_as_the_speed_loop_needs(name: str) -> None:
    motor = Motor.load(name)
    by = derive(motor, DriveDesign())
    p = control_record(motor, DriveDesign())["coupled"]
    rise = -math.log1p(-float(p["alpha_rise"])) / motor.T_s / (2.0 * math.pi)
    assert rise == pytest.approx(min(by.coupled_flux_hz, by.speed_hz / LOOP_SHARE), rel=1e-4)
    assert pytest.approx(2.0 * RISE_OVER_LOAD) == 1.0 / LOOP_SHARE


@pytest.mark.parametrize("name", NAMES)
def test_two_thirds_of_the_torque_s_acceleration_are_fed_forward(name: str) -> None:
    """The mean of inertias from one to three times the machine's own, 1 and 1/3."""
    motor = Motor.load(name)
    flux_times_current = motor.tau_rated / (1.5 * motor.n_p)  # of rated torque
    rise = motor.n_p * motor.tau_rated / motor.J  # electrical, of the machine alone
    k_tau = float(control_record(motor, DriveDesign())["coupled"]["k_tau"])
    assert k_tau * flux_times_current == pytest.approx(2.0 / 3.0 * rise, rel=1e-5)

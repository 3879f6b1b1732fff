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
    assert lean(motor, zeta) <= LEAN * (1.0 + 1e-9)
    assert zeta == DAMPING[1] or lean(motor, zeta) == pytest.approx(LEAN)
    assert DAMPING[0] < zeta <= DAMPING[1]


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


def test_dead_time_slows_the_flux_where_it_is_the_larger_noise() -> None:
    """W goes with the cubic root of the noise, the flux that a period's dead time moves."""
    motor = Motor.load("formula_wheel")
    fast, slow = (
        derive(replace(motor, dead_time=t), DriveDesign()).coupled_flux_hz
        for t in (1e-8, motor.dead_time)
    )
    step = 2.0 * motor.adc_range / 2**motor.adc_bits
    noise = motor.u_dc * motor.dead_time / (3.0 * step * motor.L_q)
    assert fast / slow == pytest.approx(noise ** (1.0 / 3.0), rel=1e-6)

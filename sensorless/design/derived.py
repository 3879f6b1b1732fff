"""Numbers of the drive that follow from the machine where the user gives none.

docs/gains.md has the reasons, docs/gains-trials.md what each constant does on machines from 0.4 to
1260 N m.
"""

import math
from dataclasses import dataclass, fields

from sensorless.design.control import stiffening
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.observers.coupled_design import bandwidths
from sensorless.observers.drift_design import trust_without_torque
from sensorless.observers.q_inductance import coupled_L_q_bias
from sensorless.observers.tracking import (
    HAND_OVER,
    flux_noise,
    injection_noise,
    rated_acceleration,
    speed_dip,
    tracking,
    unknown_drift,
    voltage_drift,
)
from sensorless.units import RPM_TO_RAD_S

DIP, MUCH_DIP = 0.1, 0.3
"""Wanted ``load_dip``, and that of a light shaft, since on half the inertia it is twice as much.
``motor check`` notes more, which 28 of 1024 random machines have."""
LOOP_SHARE = 1.0 / 18.0
"""Largest natural frequency of the speed loop over the bandwidth of the flux: faster, and the loop
makes torque of the estimate's lag and noise."""
CALM_SHARE = 2.0 * LOOP_SHARE
"""The same without torque, where the observer follows the flux more slowly: faster, and a light
shaft swings. But no slower than what dips by ``MUCH_DIP``."""
PHASE_LOSS = (0.45, math.pi / 4.0)
"""Phase that 1.5 periods of delay may take from the current loop at its crossover, 2 alpha, with
the inductances that it is designed for and with the smallest of the operating line [rad]."""
CURRENT_OVER = (2.4, 30.0)
"""Bandwidth of the current loop over rated electrical speed, or over the speed loop: more is not
needed and passes noise."""
INJECTION_SHARE = 0.87
"""Injection's PLL over ``tracking``. At 1, the drive on the SMO has about 25 % more torque ripple
and 3 % less deviation (``paper``, ``ipmsm_2200w``, ``pmsyrm_5600w``)."""
EMF_OVER, ERROR_OVER = 4.0 / 3.0, 5.0 / 3.0
"""PLL on the EMF, and on weighed errors, over injection's: the EMF's angle has less noise."""
SHARE, LEAST_SHARE = 0.75, 0.25
"""Share of the file's dead time that is compensated, and the least that an inverter may have."""
TOO_MUCH = 0.2
"""Voltage that may be compensated too much, over the EMF at the hand-over."""
SIGNAL_HZ, SIGNAL_LAG = 30.0, 0.25
"""Least bandwidth of the signals that a schedule sees [Hz], and the most that the speed among them
lags, over rated speed, where the largest current and a rated load brake: a shaft that crosses zero
within the lag does so without injection."""
FLOOR_MOST = 0.1
"""Largest speed floor over rated speed: half of the speed at which Eq. 25 leaves injection."""


@dataclass(frozen=True)
class Derived:
    """Settings of ``DriveDesign`` that it leaves to the machine, all as numbers."""

    speed_hz: float
    i_q_slew: float
    current_hz: float
    hfi_pll_hz: float
    smo_pll_hz: float
    smo_cross_hz: float
    error_pll_hz: float
    flux_pll_hz: float
    coupled_flux_hz: float
    coupled_injection_hz: float
    coupled_L_q_bias: float
    smo_floor_rpm: float
    signal_hz: float
    dead_time_share: float


def derive(motor: Motor, design: DriveDesign) -> Derived:
    """Every number of ``Derived``: that of the design, or else by its formula."""
    given = {f.name: getattr(design, f.name) for f in fields(Derived)}
    if given["speed_hz"] is None:
        given["speed_hz"] = motor.speed_hz
    speed = _first(given["speed_hz"], speed_loop(motor))
    injection = injection_loop(motor)
    emf = _first(given["smo_pll_hz"], EMF_OVER * injection)
    coupled = bandwidths(motor, speed)
    formulas = {
        "speed_hz": speed,
        "i_q_slew": 4.0 * math.pi * speed * motor.i_rated,
        "current_hz": current_loop(motor, speed),
        "hfi_pll_hz": injection,
        "smo_pll_hz": emf,
        "smo_cross_hz": emf,
        "error_pll_hz": ERROR_OVER * injection,
        "flux_pll_hz": tracking(motor, flux_noise(motor)) / (2.0 * math.pi),
        "coupled_flux_hz": coupled.flux / (2.0 * math.pi),
        "coupled_injection_hz": coupled.injection / (2.0 * math.pi),
        "coupled_L_q_bias": coupled_L_q_bias(motor),
        "smo_floor_rpm": speed_floor(motor),
        "signal_hz": signal_bandwidth(motor),
        "dead_time_share": dead_time_share(motor),
    }
    return Derived(**{name: _first(given[name], formulas[name]) for name in formulas})


def load_dip(motor: Motor, w: float) -> float:
    """Dip of the speed after a step of rated torque, over rated speed.

    Of a speed loop with a double pole at w [rad/s], see ``speed_dip``. For a dip in the place of w
    the formula gives the pole.
    """
    return speed_dip(motor, w) / motor.omega_rated


def back_after(motor: Motor, dip: float, left: float) -> float:
    """Time [s] from a step of rated torque until the speed is back within ``left`` of rated.

    ``dip``: the largest deviation over rated speed, as of ``load_dip``. It goes as e x exp(-x),
    x = w t.
    """
    if dip <= left:
        return 0.0
    x = 2.0
    for _ in range(60):  # x = 1 + ln(dip x / left) converges for x > 1
        x = 1.0 + math.log(dip * x / left)
    return x / load_dip(motor, dip)


def speed_loop(motor: Motor) -> float:
    """Natural frequency of the speed loop [Hz]: ``DIP`` after a rated load, or a share of the flux.

    The slope limit of the torque current is then 2 w i_rated, with which this loop answers a step
    of rated torque: it acts on what asks for more, steps of the reference.
    """
    flux = tracking(motor, flux_noise(motor))
    calm = max(CALM_SHARE * trust_without_torque(motor) * flux, load_dip(motor, MUCH_DIP))
    return min(load_dip(motor, DIP), LOOP_SHARE * flux, calm) / (2.0 * math.pi)


def current_loop(motor: Motor, speed_hz: float) -> float:
    """Bandwidth of the current loop [Hz] from delay, ``PHASE_LOSS``, and need, ``CURRENT_OVER``."""
    by_delay = min(PHASE_LOSS[0], PHASE_LOSS[1] / stiffening(motor)) / (3.0 * motor.T_s)
    over_speed, over_loop = CURRENT_OVER
    by_need = max(over_speed * motor.omega_rated, over_loop * 2.0 * math.pi * speed_hz)
    return min(by_delay, by_need) / (2.0 * math.pi)


def injection_loop(motor: Motor) -> float:
    """Natural frequency of the injection's PLL [Hz]: ``INJECTION_SHARE`` of ``tracking``."""
    return INJECTION_SHARE * tracking(motor, injection_noise(motor)) / (2.0 * math.pi)


def speed_floor(motor: Motor) -> float:
    """Speed [r/min] whose EMF is as large as the voltage that the drive does not know."""
    return min(unknown_drift(motor), FLOOR_MOST * motor.omega_rated) / motor.n_p / RPM_TO_RAD_S


def signal_bandwidth(motor: Motor) -> float:
    """Low-pass on a schedule's signals [Hz]: ``SIGNAL_HZ``, more where ``SIGNAL_LAG`` asks for it.

    A speed that rises by a rad/s^2 is a / (2 pi f) ahead of its low-pass.
    """
    braked = (1.0 + motor.i_max / motor.i_rated) * rated_acceleration(motor)
    fast = braked / (SIGNAL_LAG * motor.omega_rated)
    return max(SIGNAL_HZ, fast / (2.0 * math.pi))


def dead_time_share(motor: Motor) -> float:
    """Share of the dead time's voltage that is compensated: ``SHARE``, or as ``TOO_MUCH`` says."""
    emf = HAND_OVER * motor.omega_rated
    return min(SHARE, LEAST_SHARE + TOO_MUCH * emf / voltage_drift(motor))


def _first(given: float | None, formula: float) -> float:
    return formula if given is None else given

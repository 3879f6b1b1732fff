"""Start sequence: from the machine's flux map and its limits to ``start_params_t``."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.machine.magnetics import Floats, currents, flux, plant_currents
from sensorless.machine.motor import Motor
from sensorless.observers.hfi_design import error_slope
from sensorless.observers.injection_signal import sample_error
from sensorless.observers.pll_design import pll_gains
from sensorless.observers.smo_design import SWITCHING

PLL_HZ = (35.0, 50.0)
"""Natural frequencies of the injection and EMF loops while the rotor is sought [Hz]. They
have to settle within ``lock`` and ``catch``, and no torque moves the shaft meanwhile: that does not
depend on the machine."""
HOLD_SHARE = 0.3
"""Gain of the loop that holds zero current, over the deadbeat gain: damped for any inductance
between L_d and L_q, with one period of computation and the mean of two samples."""
EMF_PERIODS = 4.0
"""Periods in which the EMF is followed, angle and speed critically damped. Until it is known it
drives a current through the loop that holds zero, in T_s / HOLD_SHARE: this is not much longer."""
EMF_NOISE = 0.05
"""Noise of the EMF that is followed, over that of a shaft that counts as spinning. What takes
longer because of it:"""
EMF_TAU = 1.25e-3
"""Longest time in which the EMF is followed [s]: a sixth to a fifth of ``catch``, so that what is
left of the first error is 2.4 %."""
FLY_SHARE = 0.25
"""EMF, over its rated value, above which the shaft counts as spinning. Above it, the EMF turns by
several times its noise while it is watched; below it, the injection estimator still locks in."""
POLE_SPEED = 0.08
"""Speed, over rated, above which the EMF shows the pole: several times the error of the injection
estimator's speed at the end of LOCK."""
FOUND_SHARE = 1.25
"""Speed from which a start on a spinning shaft is promised, over the one at which the EMF shows the
pole: what is left of its noise and of the speed's error."""
PULSE_SHARE = 0.8
"""Largest pulse voltage, over the largest that the DC link allows."""
POLE_SHARE = 0.08
"""Difference of the two peaks, over rated current, at which a pulse is strong enough."""
POLE_ERROR = 0.02
"""By which the difference may be wrong, over rated current: by the current and the angle from which
a pulse starts. A decision asks for more than that, and a machine for twice that, so that its right
pole is decided on: 11 of 200 starts with a difference of 2.9 % took the wrong one."""
QUIET_SHARE = 0.1
"""Current, over rated, below which it no longer hides the EMF."""
TIMES = {
    "quiet": 12e-3,
    "catch": 7e-3,
    "fly": 16e-3,
    "again": 8e-3,
    "scan": 2e-3,
    "lock": 8e-3,
    "rest": 1.2e-3,
}
"""Lengths of the phases [s]."""


def peaks(motor: Motor, volt_seconds: float) -> tuple[float, float]:
    """Peak currents [A] of pulses of ``volt_seconds`` [Vs] along +d and along -d.

    They follow from the flux map at psi_d0 +- the volt-seconds: from rest, without resistance.
    """
    return _peaks(motor, volt_seconds, lambda psi: currents(motor.saturation, psi))


def _peaks(
    motor: Motor, volt_seconds: float, currents_at: Callable[[Floats], Floats]
) -> tuple[float, float]:
    rest = flux(motor.saturation, np.zeros((1, 2)))
    move = np.array([[volt_seconds, 0.0]])
    none = currents_at(rest)[0, 0]
    plus, minus = (currents_at(rest + sign * move)[0, 0] - none for sign in (1.0, -1.0))
    return float(plus), float(minus)


@lru_cache(maxsize=64)
def polarity_pulse(motor: Motor) -> tuple[float, float]:
    """Volt-seconds of the polarity pulses [Vs] and the signed difference of their peaks [A].

    The weakest pulse whose peaks differ by ``POLE_SHARE`` of rated current, or, where the iron
    saturates less, the strongest within ``i_max``. The difference is positive where current along
    the magnet saturates (most machines), negative where current against it does (a bridge); without
    saturation it is 0, and no pulse can distinguish the poles.
    """
    volt_seconds, difference = 0.0, 0.0
    for share in np.linspace(0.01, 1.0, 100):
        trial = float(share) * motor.L_d * motor.i_max
        plus, minus = peaks(motor, trial)
        if max(plus, -minus) > motor.i_max:
            break
        volt_seconds, difference = trial, plus + minus
        if abs(difference) >= POLE_SHARE * motor.i_rated:
            break
    return volt_seconds, difference


def knows_poles(motor: Motor) -> bool:
    """Whether saturation shows the north pole: peaks that differ by twice ``POLE_ERROR``.

    Not where the motor file says ``pole_at_rest = false``.
    """
    return motor.pole_at_rest and abs(pole_difference(motor)) >= 2.0 * POLE_ERROR * motor.i_rated


def pole_difference(motor: Motor) -> float:
    """Difference of the pulses' peaks [A], by the saturation model or by the map, if that is less.

    A model that fits a map within a percent may still see a saturation that is not there.
    """
    volt_seconds, by_model = polarity_pulse(motor)
    by_map = sum(_peaks(motor, volt_seconds, lambda psi: plant_currents(motor, psi)))
    return min(by_model, by_map, key=abs) if by_model * by_map > 0.0 else 0.0


def spin_speed(motor: Motor) -> float:
    """Speed [r/min] from which on the EMF of a spinning shaft shows the pole of every machine."""
    return FOUND_SHARE * POLE_SPEED * motor.n_rated_rpm


def alike(motor: Motor) -> str:
    """Why the poles of a machine look alike, in words."""
    if not motor.pole_at_rest:
        return "its file says pole_at_rest = false"
    found = abs(pole_difference(motor)) / motor.i_rated
    needed = f"{2.0 * POLE_ERROR:.0%} are needed"
    return f"pulses to both poles differ by {found:.1%} of rated current, {needed}"


def emf_time(motor: Motor) -> float:
    """Time constant with which the EMF is followed [s].

    An error sigma of each sample is one of L_q sigma (x_k - x_k-2) / (2 T_s) in the mean EMF of two
    periods; a low-pass of 2 T_s / tau leaves sqrt(2) L_q sigma / tau of it, whatever T_s is.
    """
    noise = math.sqrt(2.0) * motor.L_q * sample_error(motor)
    quiet = noise / (EMF_NOISE * FLY_SHARE * motor.omega_rated * motor.psi_f)
    return min(EMF_TAU, max(EMF_PERIODS * motor.T_s, quiet))


def design_start(motor: Motor, hfi: dict[str, Any], smo: dict[str, Any]) -> dict[str, Any]:
    """Fields of ``start_params_t``.

    Without saturation there are no pulses: the core keeps the pole nearer to its first angle and
    sets a fault bit.

    Parameters
    ----------
    hfi, smo : dict
        Estimators of normal operation, ``hfi_params_t`` and ``smo_params_t``. The start sequence
        runs them with loops of ``PLL_HZ``. Its observer always has the sigmoid and no low-pass,
        since it has to read the EMF within a few periods.
    """
    omega_max = smo["pll"]["omega_max"]
    loops = []
    for hertz, slope in zip(PLL_HZ, (error_slope(motor.L_d, motor.L_q), 1.0), strict=True):
        k_p, k_i = pll_gains(hertz, slope)
        loops.append({"k_p": k_p, "k_i": k_i, "omega_max": omega_max})
    volt_seconds, difference = polarity_pulse(motor) if knows_poles(motor) else (0.0, 0.0)
    u_max = PULSE_SHARE * motor.u_dc / math.sqrt(3.0)
    n_pulse = max(2, math.ceil(volt_seconds / (u_max * motor.T_s)))
    pole = math.exp(-motor.T_s / emf_time(motor))
    e_fly = FLY_SHARE * motor.omega_rated * motor.psi_f
    n = {name: max(4, round(time / motor.T_s)) for name, time in TIMES.items()}
    return {
        "hfi": {**hfi, "pll": loops[0], "n_hold": 1.0, "rise_max": 0.0},
        "smo": {**smo, "pll": loops[1], "switching": SWITCHING["sigmoid"], "alpha_e": 1.0},
        "k_hold": HOLD_SHARE * motor.L_d / motor.T_s,
        "alpha_e": 1.0 - pole**2,
        "k_turn": (1.0 - pole) ** 2 / motor.T_s,
        "e_turn_sq": (0.5 * e_fly) ** 2,
        "e_fly": e_fly,
        "omega_pole": POLE_SPEED * motor.omega_rated,
        "u_pulse": volt_seconds / (n_pulse * motor.T_s),
        "i_pole": difference,
        "i_pole_sure": max(0.4 * abs(difference), POLE_ERROR * motor.i_rated),
        "i_quiet": QUIET_SHARE * motor.i_rated,
        "n_quiet": n["quiet"],
        "n_catch": n["catch"],
        "n_fly": n["fly"],
        "n_again": n["again"],
        "n_scan": n["scan"],
        "n_lock": n["lock"],
        "n_rest": n["rest"],
        "n_pulse": n_pulse,
        "n_tries": 3,
    }

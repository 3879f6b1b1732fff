"""Tests that tell lost lock: from the machine and its loops to ``lock_params_t``.

docs/lock-trials.md has the reasons and what separates drives that hold from those that do not.
"""

import math
from typing import Any

import numpy as np

from sensorless.core.api import ffi, lib
from sensorless.machine.inverter import threshold_voltage
from sensorless.machine.magnetics import flux, iron_conductance, mtpa
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import USABLE
from sensorless.machine.saliency import principal
from sensorless.observers.injection_signal import sample_noise
from sensorless.observers.tracking import LEFT_DEAD_TIME, MOST_DEAD_TIME, rated_acceleration

ACTIONS = {name: getattr(lib, f"LOCK_{name.upper()}") for name in ("report", "restart", "stop")}
"""Numbers of the C core by the name that the setting ``lost_lock`` takes."""
EVERY = 1e-3
"""Time from one evaluation to the next [s]: that between two decisions of a schedule."""
TAU = 4e-3
"""Time constant of the tests' low-pass [s]: a half turn of slip that takes 10 ms is seen, a step of
the current is not."""
ANGLE = math.pi / 3.0
"""Angle error that is told as lost [rad]."""
SPEED_LAG = 0.15
"""Lag of an estimated speed in lock, over rated speed: after a rated load step on half the inertia,
with the slowest of the estimators."""
UNKNOWN_RESISTANCE = 0.5
"""Resistive voltage that the model lacks at rated current, over all of it."""
SPEED_SHARE = 3.0
"""Largest acceleration of a shaft, over the rated one: one and a half times rated torque, of drive
and load together, on half the inertia."""
SLIP = ANGLE / 16e-3
"""Speed [rad/s] at which an estimate slips by 60 degrees in 16 ms; those of drives that hold swing
by 40 degrees in 8 ms and back."""
LARGER = 1.1
"""d inductance that a machine may have, over that of its file, or the file's over it."""
LEADS = 0.5
"""Weight from which the injection's own angle is most of a blend of two."""
IRON = 0.03
"""Iron loss at rated speed that a machine may have, over rated power, unless its file has a larger
one: that of the suite ``stress``."""
LOADED = 0.1
"""Torque current over rated from which dead time is compensated well enough to bound the answer."""
NOISY = 4.5
"""How many times its RMS the noise of a low-passed answer may take from it: more in 3 of a million
evaluations."""
GAINED = 2.0
"""Bound on the answer over that of the d axis beyond which no channel with a wrong gain comes: one
that reads 1.5 times as much makes 1.4 to 2.1."""
TAU_LATE, LATE = 60e-3, 0.07
"""Time constant of the low-pass of what lasts [s], longer than the swing after a load step; and
what lasts in lock, over the EMF at rated speed, beside dead time and resistance:
docs/lock-trials.md, "What lasts"."""
E_LEAST = 0.75
"""Least EMF that has a direction, over the residual that lock may have on the q axis."""
ACTS = 0.1
"""Least share of the machine's injected voltage that acts, with any dead time."""
CURRENT_SHARE = 0.1
"""Distance of the torque current from its reference, over rated current, beyond the lag that the
slope of the reference makes. A mean of the current is half an evaluation older than the reference:
where the slope makes more than half of this share of that, it counts besides."""
ALARM, ACT, CLEAR, CALM = 2e-3, 2.0 * TAU, 10e-3, 1.0
"""Times [s] from the first failed test to the alarm and until the drive acts, and of passed tests
after which the alarm ends, and after which a shaft that turns forgets restarts. A drive acts when
what a swing left in the low-pass has decayed. A judge waits 10 ms; a slipping drive passes less at
a time."""
RESTARTS = 5
STALL, STALLS, STOOD, HEAVIER, ALL = 0.5, 60.0, 0.02, 10.0, 0.99
"""Least and most time with all current [s], and speed over rated, of a stall; the inertia over the
file's with which a shaft may still be starting, since rated torque takes it beyond that speed in
that time; and the share of the largest torque current that is all of it."""
LOW_LINK = 0.88
"""Least voltage of the link that a drive may take control at, over the file's: that of the suite
``stress``."""
SETTLED = 4.0
"""Time constants of the current loop, and of the tests' low-pass, in ``settled``."""


def unsure_voltage(motor: Motor) -> float:
    """Voltage that dead time takes under load, or a compensation of it adds [V]."""
    return min(LEFT_DEAD_TIME * motor.dead_time_voltage, (1.0 - ACTS) * motor.u_inj)


def taken_voltage(motor: Motor) -> float:
    """Voltage that dead time and switches take near zero current [V].

    There the injected voltage itself turns the current round, and a compensation of its mean does
    nothing: the dead time's may be ``MOST_DEAD_TIME`` times the file's, and the thresholds' is as
    much as without compensation.
    """
    taken = MOST_DEAD_TIME * motor.dead_time_voltage + threshold_voltage(motor)
    return min(taken, (1.0 - ACTS) * motor.u_inj)


def noise_voltage(motor: Motor) -> float:
    """Voltage whose answer noise may take away [V], at most the injected one.

    The answer is a quarter of a second difference of samples, sqrt(6)/4 of their noise, and passes
    the tests' low-pass.
    """
    alpha = tests_low_pass(evaluation_periods(motor) * motor.T_s)
    left = NOISY * math.sqrt(6.0) / 4.0 * math.sqrt(alpha / (2.0 - alpha))
    return min(left * sample_noise(motor) / max(_along(motor), 1e-300), motor.u_inj)


def _along(motor: Motor) -> float:
    """Least answer of the d axis over the voltage that acts, inductance ``LARGER`` [A/V]."""
    small = principal(motor, mtpa(motor)).T[0]
    return 0.5 * motor.T_s / (LARGER * float(np.max(small)))


def tests_low_pass(step: float) -> float:
    """Share of a new value that the tests' low-pass takes every ``step`` [s]."""
    return -math.expm1(-step / TAU)


def most_answer(motor: Motor) -> float:
    """Largest current that the injected voltage moves in lock [A].

    On the d axis u T_s / (2 L_small), the most along the operating line, with an inductance
    ``LARGER`` times too large in the file and the voltage that a compensation of dead time adds;
    and what an iron loss draws.
    """
    small = principal(motor, mtpa(motor)).T[0]
    acts = motor.u_inj + unsure_voltage(motor)
    p_iron = max(motor.p_iron, IRON * motor.tau_rated * motor.omega_rated / motor.n_p)
    beside = iron_conductance(motor, p_iron) * motor.u_inj
    return 0.5 * motor.T_s * acts * LARGER / float(np.min(small)) + beside


def answer_shares(motor: Motor) -> dict[str, float]:
    """What the answer to an injected voltage is bounded with, by fields of ``lock_params_t``.

    A voltage u that alternates moves the current by u T_s / 2 (cos^2 / L_small + sin^2 / L_large)
    at an angle beside the d axis. ``beside`` is that at ``ANGLE`` [A/V], ``along`` that on the axis
    with an inductance ``LARGER`` times the file's [A/V], each the least along the operating line.
    Noise may take of the answer what ``noise_voltage`` makes, so a machine whose injection
    moves the current by little more than noise has a lower bound, or none.
    ``above`` is ``most_answer`` over the voltage that acts at most [A/V]; where that is out of
    ``GAINED``'s reach, it is more than any channel reads.
    """
    small, large = principal(motor, mtpa(motor)).T
    half, noise = 0.5 * motor.T_s, noise_voltage(motor)
    unsure = unsure_voltage(motor) + noise
    beside = np.cos(ANGLE) ** 2 / small + np.sin(ANGLE) ** 2 / large
    most, reach = most_answer(motor), GAINED * motor.u_inj * half / float(np.min(small))
    return {
        "beside": half * float(np.min(beside)),
        "along": _along(motor),
        "above": (most if most < reach else 4.0 * motor.adc_range) / (motor.u_inj + unsure),
        "u_unsure": unsure,
        "u_taken": taken_voltage(motor) + noise,
    }


def answer_bounds(motor: Motor) -> dict[str, float]:
    """Bounds on the answer to the machine's injected voltage, fields of ``lock_params_t`` [A].

    From ``lock_bounds`` of the core, as a schedule of that voltage has them.
    """
    p = ffi.new("lock_params_t *", answer_shares(motor))
    lib.sim_lock_bounds(p, motor.u_inj)
    return {"answer": p.answer, "rest": p.rest, "most": p.most}


def d_share(motor: Motor) -> float:
    """Voltage on the d axis over the torque current that a lagging speed makes in lock [V/A].

    A speed that is ``SPEED_LAG`` of the rated one too small leaves that times psi_q = L_q i_q, with
    the apparent L_q at rated current.
    """
    i = mtpa(motor)
    size, psi_q = np.hypot(i[:, 0], i[:, 1]), flux(motor.saturation, i)[:, 1]
    rated = [float(np.interp(motor.i_rated, size, x)) for x in (psi_q, i[:, 1])]
    return SPEED_LAG * motor.omega_rated * rated[0] / rated[1]


def settled(motor: Motor, current: float, weakening: float) -> float:
    """Time after which the current follows its reference when a drive takes control [s].

    On a shaft whose EMF is more than the voltage of a low link it first takes field weakening.

    Parameters
    ----------
    current, weakening : float
        Bandwidths of the current loop and of field weakening [rad/s].
    """
    least = LOW_LINK * USABLE * motor.u_dc / math.sqrt(3.0)
    short = motor.omega_rated * motor.psi_f > least
    return SETTLED * (TAU + 1.0 / current) + (1.0 / weakening if short else 0.0)


def stall_current(motor: Motor) -> float:
    """Torque current beyond which a drive asks for all that ``i_max`` allows at rest [A]."""
    return ALL * float(mtpa(motor)[-1, 1])


def stall_time(motor: Motor) -> float:
    """Time that a drive asks for all its current, and stands, until it is told [s]."""
    start = HEAVIER * STOOD * motor.omega_rated / rated_acceleration(motor)
    return min(max(STALL, start), STALLS)


def evaluation_periods(motor: Motor) -> int:
    """PWM periods from one evaluation to the next."""
    return max(2, round(EVERY / motor.T_s))


def design_lock(
    motor: Motor,
    *,
    action: str,
    bias: float,
    one_axis: bool,
    i_q_slew: float,
    current_hz: float,
    weakening: float,
) -> dict[str, Any]:
    """Fields of ``lock_params_t``.

    Parameters
    ----------
    action : str
        Key of ``ACTIONS``.
    bias : float
        Observer's q inductance over the apparent one.
    one_axis : bool
        Whether injection's axis is that of the estimate, at any weight.
    i_q_slew : float
        Largest slope of the torque current's reference [A/s].
    current_hz : float
        Bandwidth of the current loop [Hz].
    weakening : float
        Bandwidth of field weakening at rated speed [rad/s].
    """
    n = evaluation_periods(motor)
    step = n * motor.T_s
    emf = motor.omega_rated * motor.psi_f
    lost = motor.dead_time_voltage + threshold_voltage(motor)
    unknown = LEFT_DEAD_TIME * lost + UNKNOWN_RESISTANCE * motor.R_s * motor.i_rated
    floor, slope = SPEED_LAG * emf + unknown, i_q_slew / motor.i_rated  # slope [1/s]
    lag = slope / (2.0 * math.pi * current_hz)
    later = 0.5 * slope * step  # reference at the end of a mean, less its mean, over i_rated
    share = max(CURRENT_SHARE, 0.5 * CURRENT_SHARE + later)
    return {
        "alpha": tests_low_pass(step),
        "inv_t": 1.0 / step,
        "R_s": motor.R_s,
        "L_q_true": 1.0 / bias,
        "e_share": 1.0 - math.cos(ANGLE),
        "e_floor": floor,
        "d_share": d_share(motor),
        "e_least": E_LEAST * floor,
        "alpha_late": -math.expm1(-step / TAU_LATE),
        "e_late": LATE * emf + lost,
        "R_warm": UNKNOWN_RESISTANCE * motor.R_s,
        "jump": SPEED_SHARE * rated_acceleration(motor) * TAU + SLIP,
        "i_off": (share + lag) * motor.i_rated,
        **answer_bounds(motor),
        "i_loaded": LOADED * motor.i_rated,
        "leads": 0.0 if one_axis else LEADS,
        **answer_shares(motor),
        "i_stall": stall_current(motor),
        "slow": STOOD * motor.omega_rated,
        "n": n,
        "n_alarm": max(2, round(ALARM / step)),
        "n_act": max(2, round(ACT / step)),
        "n_clear": max(1, round(CLEAR / step)),
        "n_calm": round(CALM / step),
        "n_stall": round(stall_time(motor) / step),
        "restarts": RESTARTS,
        "action": ACTIONS[action],
        "n_grace": math.ceil(settled(motor, 2.0 * math.pi * current_hz, weakening) / step),
    }

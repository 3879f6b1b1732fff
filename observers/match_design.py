"""Errors of the current sensors: from the machine to ``match_params_t``.

docs/coupled-learning.md derives each formula.
"""

import math
from typing import Any

import numpy as np

from sensorless.machine.magnetics import flux, mtpa
from sensorless.machine.motor import Motor
from sensorless.observers.lock_design import evaluation_periods
from sensorless.observers.smo_design import low_pass
from sensorless.observers.tracking import CHANGES, rated_acceleration

GAIN = 0.02
"""Largest error of a channel's gain, shunt or Hall sensor with its amplifier."""
OFFSET = 0.005
"""Largest offset of a channel over rated current, after the zero that a drive takes at power-up."""
ROOM = 2.0
"""Bounds on what is learned over these largest errors."""
GAIN_SPEED = 0.2
"""Speed over rated from which the gain is learned, twice the bound on the flux correction's rate at
standstill: below, voltage errors swamp what the gain makes of the flux. The mean of the error has
this bandwidth."""
GAIN_RATE = 0.05
"""Rate at which the gain is learned at rated current, over rated electrical speed: in some three
turns, so that a constant error, which has the gain swing twice a turn, hardly moves it."""
OFFSET_SPEED = 0.4
"""Speed over the bandwidth of the voltage model from which offsets are learned: there eps leads
them by 2 atan(1 / 0.4) = 136 degrees, and less above."""
FASTEST = 10.0
"""Largest rate at which offsets are learned [1/s]: beyond, noise of samples is learned."""
MOST_SWING = 3.0
"""Part of a gain in the error along psi_a that comes back by injection, over its own at rated
current, up to which the gain is learned while injection leads: docs/coupled-learning.md."""
BUSY = 3
"""Periods from one decision to the next in which the drive has no time to learn: that with the
decision and two with tests of the lock. Where there are no two others, it learns in all."""
THROWN = 0.5
"""Part of the largest offset by which a rated load step may throw the estimate at rated speed w; at
less it is more, as 1 / w."""


def design_match(
    motor: Motor, *, flux_bandwidth: float, injection: float, correction: float
) -> dict[str, Any]:
    """Fields of ``match_params_t``.

    At rated current, psi_a the auxiliary flux and W ``flux_bandwidth`` [rad/s], that of the
    voltage model:
    the error along psi_a has the slope g = 2 i / sqrt(3) (L_d psi_ad, L_qq psi_aq) / psi_a^2 in
    quadrature over the gain, so k_gain = GAIN_RATE w_rated T / (g^2 / 2),
    T the mean time between the periods in which it learns.
    A load step of acceleration a leaves an error across of a / (W^2 w) a turn; k_offset makes
    ``THROWN`` of the largest offset of it. Without enough saliency, what it learns would decay
    slower than loads change: then k_offset is 0. With much of it, ``FASTEST`` is the limit.
    The gain is learned while injection leads only if ``injection_swing`` is at most ``MOST_SWING``
    slopes, and if injection's sign alternates between the periods that learn: otherwise injection's
    own current has the swing add up without any load.

    Parameters
    ----------
    injection, correction : float
        As in ``injection_swing``.
    """
    i = mtpa(motor)
    psi = flux(motor.saturation, i)
    size = np.hypot(i[:, 0], i[:, 1])

    def rated(y: Any) -> float:
        return float(np.interp(motor.i_rated, size, y))

    T, T_offset = learning_times(motor)
    w, W = motor.omega_rated, flux_bandwidth
    i_d, i_q, L_qq = rated(i[:, 0]), rated(i[:, 1]), rated(np.gradient(psi[:, 1], i[:, 1]))
    aux = rated(psi[:, 0]) - L_qq * i_d, rated(psi[:, 1]) - motor.L_d * i_q
    square = aux[0] ** 2 + aux[1] ** 2
    slope = 2.0 * motor.i_rated / math.sqrt(3.0)
    slope *= math.hypot(motor.L_d * aux[0], L_qq * aux[1]) / square
    per_error = THROWN * OFFSET * motor.i_rated * W**2 * w / rated_acceleration(motor)
    seen = 2.0 * w**3 * W / (w**2 + W**2) ** 2
    rate = 0.5 * per_error * seen * (L_qq - motor.L_d) / math.sqrt(square)
    swing = injection_swing(motor, injection, correction)
    odd = evaluation_periods(motor) % 2 == 1
    return {
        "after": first_busy(evaluation_periods(motor)),
        "k_gain": GAIN_RATE * w * T / (0.5 * slope**2),
        "k_offset": per_error * motor.psi_f * T_offset * _share(rate),
        "gain_max": ROOM * GAIN,
        "offset_max": ROOM * OFFSET * motor.i_rated,
        "err_max": slope * GAIN,
        "alpha": low_pass(GAIN_SPEED * w / (2.0 * math.pi), T),
        "omega_gain": GAIN_SPEED * w,
        "omega_offset": OFFSET_SPEED * W,
        "alone": 0.0 if odd and swing <= MOST_SWING * slope else 1.0,
    }


def injection_swing(motor: Motor, injection: float, correction: float) -> float:
    """Error along psi_a that a gain makes by injection at ``GAIN_SPEED`` w, over the gain.

    A gain g turns injection's angle by 2 g / sqrt(3) / (1 - L_d/L_q), twice a turn. The observer
    follows it with the bandwidth ``injection`` W_h, to W_h / hypot(W_h, w), and corrects its flux
    towards that angle at the rate ``correction`` c [1/s]. In the rotor frame the correction leaves
    c w / (hypot(c, 3 w) hypot(c, w)) of it along psi_a.
    """
    w, c = GAIN_SPEED * motor.omega_rated, correction
    turned = 2.0 / math.sqrt(3.0) / (1.0 - motor.L_d / motor.L_q)
    followed = injection / math.hypot(injection, w)
    return turned * followed * c * w / (math.hypot(c, 3.0 * w) * math.hypot(c, w))


def first_busy(n: int) -> int:
    """Periods before an evaluation of the lock in which there is no time, of n."""
    return BUSY if n > BUSY + 1 else 0


def learning_time(motor: Motor) -> float:
    """Mean time between the periods in which the drive learns [s]."""
    n = evaluation_periods(motor)
    return n * motor.T_s / (n - first_busy(n))


def learning_times(motor: Motor) -> tuple[float, float]:
    """Mean times [s] between the periods that learn the gain and between those of the offsets.

    Periods from n down to 1 lead to an evaluation of the lock; odd ones learn the gain.
    """
    n = evaluation_periods(motor)
    idle = range(first_busy(n) + 1, n + 1)
    odd = sum(j % 2 for j in idle)
    return n * motor.T_s / odd, n * motor.T_s / (len(idle) - odd)


def _share(rate: float) -> float:
    """Share of the gain to use, from the rate that it would give [1/s]."""
    return min(1.0, FASTEST / rate) if rate >= CHANGES else 0.0

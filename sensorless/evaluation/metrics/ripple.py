"""Torque ripple, over the life of a drive and in the hand-over window.

The hand-over window is a place, not an action: the decisions in which the speed of the sensored
twin is within ``HANDOVER``. So it is the same for every policy, whatever band its schedule has.
There the twin's torque is subtracted: a load step, a ramp or a brake moves both and is no ripple.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d, maximum_filter1d, minimum_filter1d

from sensorless.evaluation.metrics import RIPPLE_WINDOW
from sensorless.evaluation.rollout import Floats, Rollout

HANDOVER = (0.17, 0.32)
"""Hand-over window: speed over rated, 255 to 480 r/min on the paper's motor. It is the published
band, 0.2 to 0.267, widened by a factor of 1.2 to either side: room for what the hand-over stirs up,
but above the speeds that a load step at 10 % of rated speed reaches, under injection alone."""


def torque_ripple_rms(r: Rollout) -> Floats:
    """sqrt(sum (tau - tau_mean)^2 / N) / tau_rated, tau_mean the centred 20 ms moving mean.

    It is computed from the sums of each decision j of n_j periods, S_j of tau and Q_j of tau^2. The
    moving mean at the centre of the decision is M_j = sum_i w_i S_(j+i) / sum_i w_i n_(j+i) with
    w_i = 1 for |i| < h, 1/2 for |i| = h, where 2 h decisions are 20 ms (cut at both ends of the
    life). The sum over the periods of decision j is Q_j - 2 M_j S_j + n_j M_j^2.
    """
    return _rms(r, ripple_sq(r, "tau_sq"), r.alive)


def torque_ripple_lf_rms(r: Rollout) -> Floats:
    """``torque_ripple_rms`` of the mean of two successive samples: without the injection band.

    Q_j is the sum of the squares of that mean. S_j stays, because it differs from the sum of the
    mean by half a sample at each end of the decision, which cancels from one decision to the next.
    """
    return _rms(r, ripple_sq(r, "tau_lf_sq"), r.alive)


def torque_ripple_window(r: Rollout) -> Floats:
    """sqrt(sum (dev - dev_mean)^2 / N_w) / tau_rated in the window, dev = tau - tau_twin.

    Computed like ``torque_ripple_lf_rms``, without the injection band, over the N_w periods of the
    hand-over window; NaN for a drive that never was in it.
    """
    deviation = r.sums["tau"].astype(np.float64) - r.sums["tau_twin"]
    about = _about(r, deviation, r.sums["dev_lf_sq"], _moving_mean(r, deviation))
    return _rms(r, about, in_handover(r))


def torque_p2p_window(r: Rollout) -> Floats:
    """max_j (max dev - min dev within 20 ms around decision j) / tau_rated, j in the window.

    dev = tau - tau_twin, averaged over two successive decisions (2 ms): the injection changes its
    sign every period and leaves no trace in an even number of them. NaN for a drive that never was
    in the hand-over window.
    """
    count = np.array(r.sums["n"], dtype=np.float64)
    deviation = r.sums["tau"].astype(np.float64) - r.sums["tau_twin"]
    deviation[1:] += deviation[:-1].copy()
    count[1:] += r.sums["n"][:-1]
    mean = deviation / np.maximum(count, 1.0)
    return _largest(r, _span(r, mean, mean), in_handover(r))


def torque_p2p_handover(r: Rollout) -> Floats:
    """max_j (max tau - min tau within 20 ms around decision j) / tau_rated, 0.001 < k_s_j < 0.999.

    Without the injection band; NaN if the drive never was between its two estimators. A wide blend
    stays there for longer, and every load step meanwhile counts against it: use
    ``torque_p2p_window`` to compare policies.
    """
    k_s = r.mean("k_s")
    between = (k_s > 0.001) & (k_s < 0.999)
    return _largest(r, _span(r, r.sums["tau_min"], r.sums["tau_max"]), between)


def in_handover(r: Rollout) -> NDArray[np.bool_]:
    """(d, n): the drive lives and the mean speed of its twin is in the hand-over window."""
    speed = np.abs(r.mean("omega_m_twin")) * np.float32(r.motor.n_p / r.motor.omega_rated)
    return np.asarray((speed >= HANDOVER[0]) & (speed <= HANDOVER[1]))


def ripple_sq(r: Rollout, square: str) -> Floats:
    """(d, n) sum over the periods of each decision of (tau - tau_mean)^2 [(N m)^2].

    As in ``torque_ripple_rms``; ``square`` names the sum Q, ``tau_sq`` or ``tau_lf_sq``. Rounding
    may leave a single decision below zero.
    """
    key = f"ripple of {square}"
    if key not in r.kept:
        total = np.asarray(r.sums["tau"], dtype=np.float64)
        if "moving mean" not in r.kept:
            r.kept["moving mean"] = _moving_mean(r, total)
        r.kept[key] = _about(r, total, r.sums[square], r.kept["moving mean"])
    return r.kept[key]


def _moving_mean(r: Rollout, total: Floats) -> Floats:
    """(d, n) moving mean of x over the ripple window, from its sum in each decision."""
    if not len(total):
        return np.zeros(total.shape)
    if "window periods" not in r.kept:
        count = np.asarray(r.sums["n"], dtype=np.float64)
        r.kept["window periods"] = np.maximum(_windowed(r, count), 0.5)
    mean = _windowed(r, total)
    mean /= r.kept["window periods"]
    return mean


def _windowed(r: Rollout, x: Floats) -> Floats:
    """(d, n) sum of x over the ripple window around each decision."""
    weights = np.ones(2 * _half_window(r) + 1)
    weights[[0, -1]] = 0.5
    return np.asarray(convolve1d(x, weights, axis=0, mode="constant"))


def _about(r: Rollout, total: Floats, square: Floats, mean: Floats) -> Floats:
    """(d, n) sum of (x - mean)^2 of each decision, from its sums of x and of x^2."""
    with np.errstate(over="ignore", invalid="ignore"):  # of a run that left all bounds
        out = 2.0 * mean
        out *= total
        np.subtract(square, out, out=out)
        about = mean**2
        about *= r.sums["n"]
        out += about
    return out


def _rms(r: Rollout, squares: Floats, where: NDArray[np.bool_]) -> Floats:
    """(n,) root of the mean square per period where (d, n) is set, over the rated torque."""
    periods = np.where(where, r.sums["n"], 0.0).sum(axis=0, dtype=np.float64)
    total = np.where(where, squares, 0.0).sum(axis=0)
    mean = np.maximum(total, 0.0) / np.where(periods > 0.0, periods, np.nan)
    return np.asarray(np.sqrt(mean) / r.motor.tau_rated)


def _span(r: Rollout, low: Floats, high: Floats) -> Floats:
    """(d, n) largest ``high`` minus least ``low`` within 20 ms around each decision."""
    width = 2 * _half_window(r) + 1
    high = np.where(r.alive, high, -np.inf)
    low = np.where(r.alive, low, np.inf)
    span = maximum_filter1d(high, width, axis=0, mode="constant", cval=-np.inf)
    span -= minimum_filter1d(low, width, axis=0, mode="constant", cval=np.inf)
    return np.asarray(span)


def _largest(r: Rollout, span: Floats, where: NDArray[np.bool_]) -> Floats:
    """(n,) largest value where (d, n) is set, over the rated torque; NaN where none is."""
    peak = np.where(where, span, -np.inf).max(axis=0, initial=-np.inf)
    return np.asarray(np.where(np.isfinite(peak), peak, np.nan) / r.motor.tau_rated)


def _half_window(r: Rollout) -> int:
    """Decisions in half of the ripple window, at least one."""
    return max(1, round(0.5 * RIPPLE_WINDOW / r.decision_time))

"""What a drive did in one scenario, in numbers: one function per metric, named like the metric.

Each maps a rollout to one float per scenario, over the life of the drive (until it was lost, if it
was); NaN where a metric has no meaning. Sums run over the N PWM periods k of that life.
"""

from collections.abc import Callable

import numpy as np

from sensorless.evaluation.metrics.held import away_s, not_held, swing_pct, twin_swing_pct
from sensorless.evaluation.metrics.hop import hops, k_s_hop
from sensorless.evaluation.metrics.ripple import (
    torque_p2p_handover,
    torque_p2p_window,
    torque_ripple_lf_rms,
    torque_ripple_rms,
    torque_ripple_window,
)
from sensorless.evaluation.metrics.start import backward_excess_pct, start_err_deg, start_s
from sensorless.evaluation.metrics.step import (
    dip_excess_pct_s,
    dip_pct_s,
    overshoot_clean_above,
    overshoot_clean_pct,
    overshoot_excess_pct,
    overshoot_pct,
    settling_s,
)
from sensorless.evaluation.rollout import Floats, Rollout


def torque_dev_rms(r: Rollout) -> Floats:
    """sqrt(sum (tau - tau_twin)^2 / N) / tau_rated: deviation from the sensored twin."""
    return np.asarray(np.sqrt(r.total("dev_sq")) / r.motor.tau_rated)


def torque_dev_lf_rms(r: Rollout) -> Floats:
    """``torque_dev_rms`` of the mean of two successive samples: without the injection band."""
    return np.asarray(np.sqrt(r.total("dev_lf_sq")) / r.motor.tau_rated)


def speed_dev_rms(r: Rollout) -> Floats:
    """sqrt(mean_j (omega_m - omega_m_twin)^2) / omega_m_rated, of the mean speeds of decision j."""
    deviation = np.subtract(r.mean("omega_m"), r.mean("omega_m_twin"), dtype=np.float64)
    rated = r.motor.omega_m_rated
    return np.asarray(np.sqrt(_mean_alive(r, deviation**2)) / rated)


def angle_err_mean_deg(r: Rollout) -> Floats:
    """Sum err / N, err = wrap(theta_e - theta_e_hat) [deg]."""
    return np.asarray(np.rad2deg(r.total("err")))


def angle_err_rms_deg(r: Rollout) -> Floats:
    """sqrt(sum err^2 / N) [deg]."""
    return np.asarray(np.rad2deg(np.sqrt(r.total("err_sq"))))


def angle_err_p999_deg(r: Rollout) -> Floats:
    """Smallest bound that holds in 99.9 % of the decisions for the largest |err| of each [deg].

    An upper bound of the 99.9 % quantile over the periods.
    """
    worst = np.sort(np.where(r.alive, r.sums["err_max"], -1.0), axis=0)
    count = r.alive.sum(axis=0)
    if not len(worst):
        return np.full(len(r.lost), np.nan)
    rank = len(worst) - count + np.ceil(0.999 * count).astype(np.int64) - 1
    value = worst[np.maximum(rank, 0), np.arange(len(count))]
    return np.asarray(np.rad2deg(np.where(count > 0, value, np.nan)), dtype=np.float64)


def angle_err_max_deg(r: Rollout) -> Floats:
    """Max |err| [deg]."""
    worst = r.sums["err_max"].max(axis=0, initial=0.0)
    return np.asarray(np.rad2deg(np.where(r.periods > 0, worst, np.nan)), dtype=np.float64)


def injection_share(r: Rollout) -> Floats:
    """Share of periods with injection on."""
    return r.total("injecting")


def copper_extra(r: Rollout) -> Floats:
    """Sum (|i|^2 - |i_twin|^2) / N / i_rated^2: copper loss beyond the twin's over the rated one.

    It counts the injection and the cost of a wrong angle.
    """
    return np.asarray((r.total("i_sq") - r.total("i_sq_twin")) / r.motor.i_rated**2)


def k_s_activity(r: Rollout) -> Floats:
    """Sum |k_s(k) - k_s(k-1)| / (N T_s): total variation of the weight per second [1/s]."""
    return np.asarray(r.total("k_s_moved") / r.motor.T_s)


METRICS: dict[str, Callable[[Rollout], Floats]] = {
    f.__name__: f
    for f in (
        torque_dev_rms,
        torque_dev_lf_rms,
        torque_ripple_rms,
        torque_ripple_lf_rms,
        torque_p2p_handover,
        torque_ripple_window,
        torque_p2p_window,
        overshoot_pct,
        overshoot_excess_pct,
        overshoot_clean_pct,
        overshoot_clean_above,
        settling_s,
        dip_pct_s,
        dip_excess_pct_s,
        speed_dev_rms,
        away_s,
        swing_pct,
        twin_swing_pct,
        not_held,
        angle_err_mean_deg,
        angle_err_rms_deg,
        angle_err_p999_deg,
        angle_err_max_deg,
        injection_share,
        copper_extra,
        k_s_activity,
        k_s_hop,
        hops,
        start_s,
        start_err_deg,
        backward_excess_pct,
    )
}
"""All metrics by name, in the order in which they are reported."""


def _mean_alive(r: Rollout, x: Floats) -> Floats:
    """(n,) mean of (d, n) over the decisions a drive lived."""
    count = r.alive.sum(axis=0)
    total = np.where(r.alive, x, 0.0).sum(axis=0)
    return np.asarray(total / np.where(count > 0, count, np.nan))

"""How drives started that first had to find their rotor: metrics (n,), NaN for others.

While the start sequence runs, ``sums["starting"]`` counts its periods, angle errors read 0 and lost
lock does not count. The sensored twin waits at zero torque and begins to control in the same
period, so until then the load moves both shafts alike.
"""

import numpy as np

from sensorless.evaluation.rollout import Floats, Rollout

AFTER = 0.01
"""Time after the sequence in which the angle is judged [s]."""


def start_s(r: Rollout) -> Floats:
    """Sum of the periods of the start sequence times T_s [s]."""
    periods = r.sums["starting"].sum(axis=0, dtype=np.float64)
    return np.asarray(np.where(_sought(r), periods * r.motor.T_s, np.nan))


def start_err_deg(r: Rollout) -> Floats:
    """Max |err| in the 10 ms after the sequence [deg]; near 180 with the wrong polarity.

    NaN also if the drive was lost before its sequence ended.
    """
    done = _sought(r) & (r.sums["starting"] < r.sums["n"]).any(axis=0)
    first = (r.sums["starting"] > 0.0).sum(axis=0)
    rows = np.arange(len(r.sums))[:, None]
    window = (rows >= first - 1) & (rows <= first + max(1, round(AFTER / r.decision_time)))
    worst = np.where(window, r.sums["err_max"], 0.0).max(axis=0, initial=0.0)
    return np.asarray(np.where(done, np.rad2deg(worst), np.nan))


def backward_excess_pct(r: Rollout) -> Floats:
    """100 (b - b_twin) / omega_m_rated, b = max_j max(0, -d omega_m), d the wanted direction [%].

    How much faster it ran backwards than the sensored twin, which the same load moves: from
    standstill, against the direction of the last speed target. NaN on a spinning shaft or without a
    target.
    """
    target = np.take_along_axis(r.scenarios.omega, _last_segment(r)[:, None], axis=1)[:, 0]
    way = np.sign(target)
    backward = [
        np.where(r.alive, np.maximum(-way * r.mean(name), 0.0), 0.0).max(axis=0, initial=0.0)
        for name in ("omega_m", "omega_m_twin")
    ]
    rated = r.motor.omega_m_rated
    judged = _sought(r) & (r.scenarios.omega_0 == 0.0) & (way != 0.0)
    return np.asarray(np.where(judged, 100.0 * (backward[0] - backward[1]) / rated, np.nan))


def _sought(r: Rollout) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(n,) whether the drive ran a start sequence."""
    return np.asarray((r.sums["starting"] > 0.0).any(axis=0))


def _last_segment(r: Rollout) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """(n,) the last segment that begins before the scenario ends."""
    begun = r.scenarios.t < r.scenarios.duration[:, None]
    return np.asarray(begun.sum(axis=1) - 1)

"""Whether a drive that kept lock also holds its speed: limit cycles, and drives that stay off.

The sensored twin is the yardstick: what it does too under the same load is no fault of an
estimator. A change is any movement of the speed reference, the load or the DC link, from its
beginning to its end; the start counts as one. Each metric is (n,), a number per scenario.
"""

from itertools import combinations

import numpy as np

from sensorless.core.api import Array
from sensorless.evaluation.lock import BAND
from sensorless.evaluation.metrics.profile import reference, since_change
from sensorless.evaluation.rollout import Floats, Rollout

BAND_PCT = 100.0 * BAND
"""Band around the twin's speed, and largest swing beyond the twin's [% of rated speed]."""
FAR = 0.1
"""Beyond this the drive is off even while its twin is on the way [of rated speed]. Two drives that
accelerate at the same current drift apart by what an angle error costs of the torque; 25 degrees
cost 1 - cos 25 deg = 9 %, of a way from standstill to rated speed."""
BACK_TIME = 0.5
"""Time within which the speed has to come back after a change [s]; the sensored drive of the
paper's motor needs 0.22 s after a rated load step on half the inertia."""
QUIET = 0.3
"""Time after a change before a swing counts [s]."""
NEEDED = ("n", "omega_m", "omega_m_twin", "starting")
"""Fields of ``sums_t`` that a rollout has to keep for these metrics."""
BLOCK = 0.1
"""Half the width of a window [s]; two cycles of 10 Hz fit into a window."""


def away_s(r: Rollout) -> Floats:
    """max_j t_j with |omega_m - omega_m_twin| > 2 % of rated, t_j since the last change [s].

    Speeds are means over decision j; 0 if the speed was never off while nothing changed. A drive
    within that band of the reference is not off, whatever its twin does; nor is one within 10 % of
    a twin that itself has not come within the band of the reference: both are on the way.
    """
    rated = r.motor.omega_m_rated
    drive, twin, band = r.mean("omega_m"), r.mean("omega_m_twin"), 0.01 * BAND_PCT * rated
    off = np.abs(drive - twin) > band
    if off.any():
        wanted = reference(r)
        off &= np.abs(drive - wanted) > band
        off &= (np.abs(twin - wanted) <= band) | (np.abs(drive - twin) > FAR * rated)
    time = np.where(off, np.maximum(since_change(r), 0.0), 0.0)
    return np.asarray(np.where(r.periods > 0, time.max(axis=0, initial=0.0), np.nan))


def swing_pct(r: Rollout) -> Floats:
    """max_w min(s_w, s_w+1, s_w+2), s = 100 (p2p omega_m - p2p omega_m_twin) / rated speed [%].

    The lasting swing, over three successive windows of 0.2 s. The first begins at least 0.3 s after
    the last change, the last ends before the next change; windows begin every 0.1 s. NaN without
    three such windows.
    """
    if (size := _block_of(r)) == 0:
        return np.full(len(r.lost), np.nan)
    drive, twin = (_peak_to_peak(in_blocks(r.mean(x), size)) for x in ("omega_m", "omega_m_twin"))
    return _most(r, size, _lasting(drive - twin))


def twin_swing_pct(r: Rollout) -> Floats:
    """The same of the twin alone, and no more than it goes up, down and up again in 0.6 s [%].

    Or down, up and down. Beyond 2 % the control itself swings; a speed that settles does not.
    """
    if (size := _block_of(r)) == 0:
        return np.full(len(r.lost), np.nan)
    x = in_blocks(r.mean("omega_m_twin"), size)
    high, low, n = x.max(axis=1), x.min(axis=1), len(x) - 5
    swing = np.zeros((n, x.shape[2]))
    for at in combinations(range(6), 4):  # blocks of a turning point each
        for a, b, sign in ((high, low, 1.0), (low, high, -1.0)):
            ends = [(a if j % 2 == 0 else b)[k : n + k] for j, k in enumerate(at)]
            legs = (ends[0] - ends[1], ends[2] - ends[1], ends[2] - ends[3])
            swing = np.maximum(swing, np.min([sign * leg for leg in legs], axis=0))
    return _most(r, size, np.minimum(_lasting(_peak_to_peak(x)), swing))


def _block_of(r: Rollout) -> int:
    """Decisions in a block; 0 where there are not six blocks, as three windows take."""
    size = max(1, round(BLOCK / r.decision_time))
    return size if len(r.sums) // size >= 6 else 0


def _lasting(swing: Floats) -> Floats:
    """The least in three successive windows, of swings in windows that begin every block."""
    return np.asarray(np.minimum(np.minimum(swing[:-4], swing[2:-2]), swing[4:]))


def _most(r: Rollout, size: int, swing: Floats) -> Floats:
    """(n,) largest swing over rated speed where nothing changes [%]; NaN without such a time."""
    quiet = in_blocks(np.where(r.alive, since_change(r), -1.0), size).min(axis=1) >= QUIET
    inside = np.logical_and.reduce([quiet[j : len(swing) + j] for j in range(6)])
    most = np.where(inside, swing, -np.inf).max(axis=0, initial=-np.inf)
    return np.asarray(np.where(np.isfinite(most), 100.0 * most / r.motor.omega_m_rated, np.nan))


def not_held(r: Rollout) -> Floats:
    """1 if away_s > 0.5 s or swing_pct > 2 %, else 0; its mean is a share of the survivors.

    ``not_held_rate`` of the results is over the feasible scenarios; lost drives do not count in it.
    """
    away = away_s(r)
    return np.where(np.isnan(away), np.nan, (away > BACK_TIME) | (swing_pct(r) > BAND_PCT))


def in_blocks(x: Array, size: int) -> Array:
    """Reshape (d, n) to (blocks, size, n), without the remainder at the end."""
    blocks = len(x) // size
    return x[: blocks * size].reshape(blocks, size, x.shape[1])


def _peak_to_peak(x: Array) -> Floats:
    """(blocks - 1, n) peak to peak over two successive blocks."""
    high, low = x.max(axis=1), x.min(axis=1)
    return np.asarray(np.maximum(high[:-1], high[1:]) - np.minimum(low[:-1], low[1:]))

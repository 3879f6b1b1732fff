"""Whether a schedule moves k_s where nothing asks for it: at constant speed, load and DC link.

The sensored twin tells when a change has passed, so the time is the same for every policy. Each
metric is (n,), a number per scenario.
"""

import numpy as np

from sensorless.evaluation.metrics.held import BLOCK, QUIET, in_blocks
from sensorless.evaluation.metrics.profile import reference, since_change
from sensorless.evaluation.rollout import Floats, Rollout

SETTLED = 0.002
"""The twin has settled when its speed is this near the reference, over rated speed: over the band
of Eq. 25, 6.7 % of rated speed, such a difference is worth 0.03 of k_s."""
HOP = 0.05
"""Peak to peak of k_s above which it hops."""


def k_s_hop(r: Rollout) -> Floats:
    """max_b (max k_s - min k_s) over the stretch of rest up to block b; k_s is the one in force.

    Blocks have 0.1 s, k_s is its mean over a decision. At rest are blocks that begin at least 0.3 s
    after the last change, end before the next, and have |omega_m_twin - omega_m_ref| <= 0.2 % of
    rated speed throughout; a stretch is successive ones. NaN without any.
    """
    if "k_s_hop" in r.kept:
        return r.kept["k_s_hop"]
    size = max(1, round(BLOCK / r.decision_time))
    settled = np.abs(r.mean("omega_m_twin") - reference(r)) <= SETTLED * r.motor.omega_m_rated
    rest = in_blocks(r.alive & settled & (since_change(r) >= QUIET), size).min(axis=1)
    k_s = in_blocks(r.mean("k_s"), size)
    most, least = (np.full(len(r.lost), fill) for fill in (-np.inf, np.inf))
    hop = np.full(len(r.lost), -np.inf)
    for at_rest, high, low in zip(rest, k_s.max(axis=1), k_s.min(axis=1), strict=True):
        most = np.where(at_rest, np.fmax(most, high), -np.inf)
        least = np.where(at_rest, np.fmin(least, low), np.inf)
        hop = np.where(at_rest, np.maximum(hop, most - least), hop)
    r.kept["k_s_hop"] = np.where(np.isfinite(hop), hop, np.nan)
    return r.kept["k_s_hop"]


def hops(r: Rollout) -> Floats:
    """1 if k_s_hop > 0.05, else 0; its mean is the share of scenarios in which k_s hops."""
    hop = k_s_hop(r)
    return np.where(np.isnan(hop), np.nan, hop > HOP)

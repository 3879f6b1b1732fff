"""95 % intervals of rates, and of the difference of two rates over the same scenarios.

A bootstrap would have no width where nothing was lost, as if nothing ever could be.
"""

import math

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Groups = NDArray[np.intp]
"""(n,) number of the group that each scenario belongs to, of those that resemble each other."""
Interval = tuple[float, float]
Z = 1.959963984540054
"""95 % of a normal distribution lie within so many standard deviations."""


def mean(x: Bools | NDArray[np.float64]) -> float:
    """Mean of ``x`` (n,), a rate if it is of hits; NaN for n = 0."""
    return float(np.mean(x)) if len(x) else math.nan


def rate_interval(hits: Bools, groups: Groups | None = None) -> Interval:
    """Wilson score interval of the rate of ``hits`` (n,); NaN for n = 0.

    With ``groups`` for as many scenarios as tell as much if each stood alone: n over the variance
    between groups, over that of independent hits (Rao and Scott, doi 10.2307/2532311). Where there
    is no hit, or nothing else, that cannot be told, and they count as independent. One group alone
    tells as much as one scenario.
    """
    if not len(hits):
        return math.nan, math.nan
    p, n = float(hits.mean()), len(hits) / _by_groups(hits, groups)
    middle, width = p + Z**2 / (2.0 * n), math.sqrt(p * (1.0 - p) / n + (Z / (2.0 * n)) ** 2)
    low, high = ((middle + sign * Z * width) / (1.0 + Z**2 / n) for sign in (-1.0, 1.0))
    return max(low, 0.0) if p > 0.0 else 0.0, min(high, 1.0) if p < 1.0 else 1.0


def _by_groups(hits: Bools, groups: Groups | None) -> float:
    """How many times as wide groups make the variance of a rate, at least 1."""
    p = float(hits.mean())
    if groups is None or p in (0.0, 1.0):
        return 1.0
    size = np.bincount(groups)
    apart = np.bincount(groups, hits) - p * size
    m = int(np.count_nonzero(size))
    if m < 2:
        return float(len(hits))
    return max(1.0, m / (m - 1) * float(apart @ apart) / (len(hits) * p * (1.0 - p)))


def difference_interval(here: Bools, there: Bools, groups: Groups | None = None) -> Interval:
    """Interval of the rate of ``here`` (n,) minus that of ``there``, pair by pair; NaN for n = 0.

    From the two Wilson intervals and the correlation of the pairs: method 10 of
    Newcombe, doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C. With
    ``groups`` both are of their totals.
    """
    if not len(here):
        return math.nan, math.nan
    (low, high), (low_2, high_2) = rate_interval(here, groups), rate_interval(there, groups)
    p, p_2 = float(here.mean()), float(there.mean())
    phi = _correlation(here, there) if groups is None else _between(here, there, groups)

    def width(one: float, other: float) -> float:
        return math.sqrt(max(one**2 - 2.0 * phi * one * other + other**2, 0.0))

    return p - p_2 - width(p - low, high_2 - p_2), p - p_2 + width(high - p, p_2 - low_2)


def _correlation(here: Bools, there: Bools) -> float:
    """Phi of the pairs; where it is positive, a continuity correction brings it nearer to 0."""
    n, both, neither = len(here), int(np.sum(here & there)), int(np.sum(~here & ~there))
    only_here, only_there = int(np.sum(here & ~there)), int(np.sum(there & ~here))
    sides = float(here.sum()) * float(there.sum()) * float((~here).sum()) * float((~there).sum())
    if sides == 0.0:
        return 0.0
    excess = float(both * neither - only_here * only_there)
    return (max(excess - n / 2.0, 0.0) if excess > 0.0 else excess) / math.sqrt(sides)


def _between(here: Bools, there: Bools, groups: Groups) -> float:
    """Correlation of the totals of groups, each less its size times the rate; 0 if undefined."""
    size = np.bincount(groups)
    a, b = (np.bincount(groups, x) - x.mean() * size for x in (here, there))
    both = float(a @ a) * float(b @ b)
    return float(a @ b) / math.sqrt(both) if both > 0.0 else 0.0

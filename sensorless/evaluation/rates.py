"""95 % intervals of rates, and of the difference of two rates over the same scenarios.

A bootstrap would have no width where nothing was lost, as if nothing ever could be.
"""

import math

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Interval = tuple[float, float]


def mean(x: Bools | NDArray[np.float64]) -> float:
    """Mean of ``x`` (n,), a rate if it is of hits; NaN for n = 0."""
    return float(np.mean(x)) if len(x) else math.nan


def rate_interval(hits: Bools) -> Interval:
    """Wilson score interval of the rate of ``hits`` (n,); NaN for n = 0."""
    if not len(hits):
        return math.nan, math.nan
    from scipy.stats import binomtest  # two fifths of the start of a worker, which needs none

    test = binomtest(int(hits.sum()), len(hits))
    interval = test.proportion_ci(confidence_level=0.95, method="wilson")
    return float(interval.low), float(interval.high)


def difference_interval(here: Bools, there: Bools) -> Interval:
    """Interval of the rate of ``here`` (n,) minus that of ``there``, pair by pair; NaN for n = 0.

    From the two Wilson intervals and the correlation of the pairs: method 10 of
    Newcombe, doi 10.1002/(SICI)1097-0258(19981130)17:22<2635::AID-SIM954>3.0.CO;2-C.
    """
    if not len(here):
        return math.nan, math.nan
    (low, high), (low_2, high_2) = rate_interval(here), rate_interval(there)
    p, p_2, phi = float(here.mean()), float(there.mean()), _correlation(here, there)

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

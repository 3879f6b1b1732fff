"""Intervals of rates, against textbook formulas, published figures, and their own coverage."""

import math

import numpy as np
import pytest

from sensorless.evaluation.rates import Bools, difference_interval, rate_interval


def wilson(hits: float, n: int, z: float = 1.959964) -> tuple[float, float]:
    """Textbook formula (doi 10.1080/01621459.1927.10502953)."""
    p = hits / n
    centre = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return centre - half, centre + half


@pytest.mark.parametrize(("hits", "n"), [(0, 1), (0, 50), (3, 50), (25, 50), (50, 50), (7, 1000)])
def test_rate_interval_is_wilsons(hits: int, n: int) -> None:
    assert rate_interval(np.arange(n) < hits) == pytest.approx(wilson(hits, n), abs=1e-6)


def pairs(both: int, here: int, there: int, neither: int) -> tuple[Bools, Bools]:
    first = np.repeat([True, True, False, False], [both, here, there, neither])
    return first, np.repeat([True, False, True, False], [both, here, there, neither])


@pytest.mark.parametrize(
    ("counts", "interval"),
    [((36, 12, 2, 0), (0.0569, 0.3404)), ((20, 12, 2, 16), (0.0562, 0.3292))],
)
def test_differences_are_those_of_the_paper(
    counts: tuple[int, int, int, int], interval: tuple[float, float]
) -> None:
    """Method 10, table II, of Newcombe 1998."""
    assert difference_interval(*pairs(*counts)) == pytest.approx(interval, abs=5e-5)


def test_nothing_lost_is_not_certainty() -> None:
    """With no loss in n pairs either rate may be Wilson's upper bound of 0 of n."""
    low, high = difference_interval(*pairs(0, 0, 0, 400))
    assert -low == high == pytest.approx(wilson(0, 400)[1], abs=1e-6)


def test_the_same_losses_are_closer_than_as_many_others() -> None:
    same, others = (difference_interval(*pairs(*x)) for x in ((20, 0, 0, 80), (0, 20, 20, 60)))
    assert 0.0 < same[1] < 0.25 * others[1]


@pytest.mark.parametrize(
    ("here", "there", "both"), [(0.01, 0.005, 0.0), (0.05, 0.03, 0.02), (0.2, 0.1, 0.1)]
)
def test_95_of_100_intervals_hold_the_truth(here: float, there: float, both: float) -> None:
    rng, held, n = np.random.default_rng(1), 0, 500
    for _ in range(n):
        counts = rng.multinomial(200, [both, here, there, 1.0 - both - here - there])
        low, high = difference_interval(*pairs(*counts))
        held += low <= here - there <= high
    assert held / n >= 0.93


def test_no_scenario_has_no_interval() -> None:
    nothing = np.zeros(0, dtype=np.bool_)
    for interval in (rate_interval(nothing), difference_interval(nothing, nothing)):
        assert np.isnan(interval).all()


def test_groups_that_end_alike_count_as_one_each() -> None:
    """16 scenarios on each of 50 machines tell as much as one on 49."""
    machines = np.arange(50) < 5
    groups = np.repeat(np.arange(50), 16)
    found = rate_interval(np.repeat(machines, 16), groups)
    assert found == pytest.approx(wilson(0.1 * 49, 49), abs=1e-6)


def test_groups_that_are_more_alike_than_chance_make_no_interval_narrower() -> None:
    """Half of every group: no variance between them."""
    hits = np.arange(32) % 2 == 0
    assert rate_interval(hits, np.repeat(np.arange(8), 4)) == rate_interval(hits)


def test_scenarios_of_a_single_group_tell_as_much_as_one() -> None:
    one = rate_interval(np.arange(32) < 8, np.zeros(32, dtype=np.intp))
    assert one == pytest.approx(wilson(0.25, 1), abs=1e-6)


def test_groups_without_a_pattern_change_little() -> None:
    hits, groups = np.random.default_rng(3).random(16_000) < 0.1, np.repeat(np.arange(1000), 16)
    free, grouped = rate_interval(hits), rate_interval(hits, groups)
    assert np.ptp(grouped) == pytest.approx(np.ptp(free), rel=0.05)
    assert np.ptp(grouped) >= np.ptp(free)


def test_95_of_100_grouped_intervals_hold_the_truth() -> None:
    """Losses gather: a tenth of the machines lose a quarter, the others a hundredth."""
    rng, groups = np.random.default_rng(2), np.repeat(np.arange(64), 16)
    held, free, truth = 0, 0, 0.1 * 0.25 + 0.9 * 0.01
    for _ in range(400):
        rate = np.where(rng.random(64) < 0.1, 0.25, 0.01)
        hits = rng.random(1024) < rate[groups]
        for name in ("grouped", "free"):
            low, high = rate_interval(hits, groups if name == "grouped" else None)
            inside = low <= truth <= high
            held, free = held + (inside and name == "grouped"), free + (inside and name == "free")
    assert held / 400 >= 0.9 > 0.85 >= free / 400


@pytest.mark.parametrize(
    ("size", "share", "bad", "good"),
    [(64, 0.1, 0.25, 0.01), (64, 0.3, 0.5, 0.05), (25, 0.3, 0.5, 0.05)],
)
def test_95_of_100_grouped_differences_hold_the_truth_and_no_more(
    size: int, share: float, bad: float, good: float
) -> None:
    """Both rules lose on the same machines, one 1.2 times as often, in other scenarios."""
    rng, groups = np.random.default_rng(4), np.repeat(np.arange(size), 16)
    held, width, found, n = 0, 0.0, [], 400
    truth = 0.2 * (share * bad + (1.0 - share) * good)
    for _ in range(n):
        rate = np.where(rng.random(size) < share, bad, good)[groups]
        here, there = rng.random(16 * size) < 1.2 * rate, rng.random(16 * size) < rate
        low, high = difference_interval(here, there, groups)
        held, width = held + (low <= truth <= high), width + (high - low) / n
        found.append(here.mean() - there.mean())
    assert 0.92 <= held / n <= 0.98
    assert width < 1.25 * 2.0 * 1.96 * np.std(found)


def test_groups_of_which_none_differs_have_no_correlation() -> None:
    """Either rate is the same on all of them, or there is but one."""
    hits, groups = np.arange(32) % 2 == 0, np.repeat(np.arange(2), 16)
    ends = [rate_interval(hits, groups)[i] - 0.5 for i in (0, 1)]
    low, high = difference_interval(hits, hits, groups)
    assert (low, high) == pytest.approx((-math.hypot(*ends), math.hypot(*ends)))
    assert np.isfinite(difference_interval(hits, hits, np.zeros(32, dtype=np.intp))).all()

"""Rates, means and their intervals."""

import math

import numpy as np
import pytest

from sensorless.evaluation.aggregate import (
    by_place,
    mean_interval,
    mean_of,
    paired,
    summary,
    worst,
)
from sensorless.evaluation.metrics.place import PLACE
from sensorless.evaluation.rates import difference_interval, rate_interval

pytestmark = pytest.mark.usefixtures("all_draws")

MACHINES = np.repeat(np.arange(10), 10)
"""Group of each of 100 scenarios, ten to a machine."""
FIRST_TWO = MACHINES < 2
NONE = np.zeros(100, dtype=np.int32)


def test_mean_interval_is_that_of_the_normal_law_for_many_values() -> None:
    x = np.random.default_rng(5).normal(3.0, 2.0, 400)
    low, high = mean_interval(x, 1)
    half = 1.96 * x.std(ddof=1) / 20.0
    assert low == pytest.approx(x.mean() - half, abs=0.1 * half)
    assert high == pytest.approx(x.mean() + half, abs=0.1 * half)


def test_mean_interval_depends_on_values_and_seed_only() -> None:
    x = np.random.default_rng(5).normal(0.0, 1.0, 30)
    assert mean_interval(x, 1) == mean_interval(x, 1)
    assert mean_interval(x, 1) != mean_interval(x, 2)


def test_values_that_come_in_groups_are_drawn_by_groups() -> None:
    machines, groups = np.random.default_rng(5).normal(0.0, 1.0, 30), np.repeat(np.arange(30), 16)
    assert mean_interval(np.repeat(machines, 16), 1, groups) == pytest.approx(
        mean_interval(machines, 1)
    )
    some = groups > 2  # the numbers of groups need not begin at 0
    assert mean_interval(np.repeat(machines, 16)[some], 1, groups[some]) == pytest.approx(
        mean_interval(machines[3:], 1)
    )


def test_a_large_group_counts_as_all_of_its_scenarios() -> None:
    """Twenty machines with one scenario of 0, twenty with nine of 1: the mean is 0.9, not 0.5."""
    size, ends = np.tile([1, 9], 20), np.tile([0.0, 1.0], 20)
    low, high = mean_interval(np.repeat(ends, size), 1, np.repeat(np.arange(40), size))
    assert low < 0.9 < high


def test_too_few_values_have_no_interval() -> None:
    assert all(map(math.isnan, mean_interval(np.ones(1), 0)))
    assert mean_interval(np.ones(2), 0) == (1.0, 1.0)


def test_means_leave_out_rows_and_scenarios_without_the_metric() -> None:
    x = np.array([1.0, 2.0, np.nan, 6.0, 100.0])
    rows = np.array([True, True, True, True, False])
    out = mean_of({"x": x, "none": np.full(5, np.nan)}, rows, 0)
    assert out["x"] == 3.0
    assert 1.0 <= out["x_ci"][0] < 3.0 < out["x_ci"][1] <= 6.0
    assert out["defined"] == {"x": 3, "none": 0}
    assert math.isnan(out["none"]) and all(map(math.isnan, out["none_ci"]))


def test_summary_counts_every_early_end_of_a_feasible_scenario_as_lost() -> None:
    lost = np.array([0, 1, 8, 0, 1 | 2, 0, 4, 0, 0, 0], dtype=np.int32)
    x = np.array([1.0, 50.0, 50.0, 2.0, 50.0, 3.0, np.nan, 1.0, 2.0, 3.0])
    out = summary(lost, {"x": x}, 0)
    assert out["lost_rate"] == 3 / 9
    assert out["lost_ci"] == pytest.approx(rate_interval(np.arange(9) < 3), abs=1e-6)
    assert out["infeasible_rate"] == 0.1
    assert out["lost_by_cause"] == {"angle": 2, "current": 1, "nonfinite": 1, "twin": 1}
    assert out["survived"] == 6
    assert out["x"] == 2.0


def test_rates_of_groups_have_the_intervals_of_groups() -> None:
    loose = np.where(MACHINES == 5, 1.0, 0.0)
    out = summary(FIRST_TWO.astype(np.int32), {"not_held": loose}, 0, MACHINES)
    assert out["lost_ci"] == rate_interval(FIRST_TWO, MACHINES)
    assert out["not_held_rate_ci"] == rate_interval(loose > 0.0, MACHINES)


def test_everything_lost_leaves_no_means() -> None:
    out = summary(np.ones(3, dtype=np.int32), {"x": np.ones(3)}, 0)
    assert out["lost_rate"] == 1.0
    assert math.isnan(out["x"])


def test_pairs_are_scenarios_that_both_survive() -> None:
    here = np.array([0, 0, 0, 1, 0, 1], dtype=np.int32)
    there = np.array([0, 0, 0, 0, 1, 8], dtype=np.int32)
    x = np.array([3.0, 5.0, np.nan, 1e9, 1e9, 1e9])
    reference = np.array([1.0, 2.0, 7.0, 0.0, 0.0, 0.0])
    out = paired(here, {"x": x}, there, {"x": reference}, 0)
    assert (out["survived_both"], out["lost_only_here"], out["lost_only_there"]) == (3, 1, 1)
    assert out["x"] == 2.5
    assert out["x_ci"] == (2.0, 3.0)
    assert out["defined"] == {"x": 2}
    assert out["lost_rate"] == 0.0
    assert out["there"] == {"lost_rate": 1 / 5, "x": 1.5}


def test_pairs_of_groups_have_the_intervals_of_groups() -> None:
    held, loose = np.zeros(100), np.where(MACHINES == 5, 1.0, 0.0)
    lost = FIRST_TWO.astype(np.int32)
    out = paired(lost, {"not_held": loose}, NONE, {"not_held": held}, 0, MACHINES)
    assert out["lost_rate_ci"] == difference_interval(FIRST_TWO, NONE > 0, MACHINES)
    assert out["not_held_rate_ci"] == difference_interval(loose > 0.0, held > 0.0, MACHINES)


def test_pairing_sees_a_difference_that_means_apart_would_hide() -> None:
    rng = np.random.default_rng(0)
    hard = rng.normal(10.0, 5.0, 100)
    better = hard - rng.normal(0.2, 0.1, 100)
    none = np.zeros(100, dtype=np.int32)
    out = paired(none, {"x": better}, none, {"x": hard}, 3)
    apart = [summary(none, {"x": x}, 3)["x_ci"] for x in (better, hard)]
    assert out["x_ci"][1] < 0.0
    assert apart[0][1] > apart[1][0]


def test_one_policy_twice_differs_by_nothing() -> None:
    lost = np.array([0, 1, 0, 0], dtype=np.int32)
    x = {"x": np.array([1.0, 2.0, 3.0, 4.0])}
    out = paired(lost, x, lost, x, 0)
    assert out["x"] == 0.0 and out["x_ci"] == (0.0, 0.0)
    assert out["lost_rate"] == 0.0
    low, high = out["lost_rate_ci"]
    assert -low == pytest.approx(high) and 0.0 < high


def test_places_count_who_came_and_who_was_lost_there() -> None:
    places = np.zeros((4, 2), dtype=PLACE)
    places["periods"] = [[10, 0], [10, 10], [5, 10], [30, 0]]
    places["err_sq"] = np.deg2rad(2.0) ** 2 * places["periods"]
    places["dev_sq"][3] = [0.09 * 30, 0.0]
    places["lost"][2, 1] = True
    out = by_place(places, np.array([True, True, False, True]))
    assert (out["came"], out["lost"], out["lost_rate"]) == ([4, 2], [0, 1], [0.0, 0.5])
    assert out["lost_ci"][1] == pytest.approx(rate_interval(np.arange(2) < 1), abs=1e-6)
    assert out["time_share"] == pytest.approx([50 / 60, 10 / 60])
    assert out["angle_err_rms_deg"] == pytest.approx([2.0, 2.0])
    assert out["torque_dev_rms"] == pytest.approx([math.sqrt(2.7 / 50), 0.0])


def test_a_place_of_groups_has_the_interval_of_groups() -> None:
    places = np.zeros((100, 1), dtype=PLACE)
    places["periods"], places["lost"][:, 0] = 1, FIRST_TWO
    (found,) = by_place(places, ~FIRST_TWO, MACHINES)["lost_ci"]
    assert found == rate_interval(FIRST_TWO, MACHINES)


def test_a_place_where_nobody_came_has_no_rate() -> None:
    out = by_place(np.zeros((3, 1), dtype=PLACE), np.ones(3, dtype=bool))
    assert out["came"] == [0]
    assert math.isnan(out["lost_rate"][0]) and math.isnan(out["angle_err_rms_deg"][0])


def test_not_held_counts_survivors_over_feasible_scenarios() -> None:
    lost = np.array([0, 0, 0, 1, 0, 8], dtype=np.int32)
    loose = {"not_held": np.array([1.0, 0.0, 0.0, 1.0, 1.0, 1.0])}
    out = summary(lost, loose, 0)
    assert (out["not_held_rate"], out["lost_rate"]) == (0.4, 0.2)
    assert out["not_held_rate_ci"] == pytest.approx(rate_interval(np.arange(5) < 2), abs=1e-6)
    other = {"not_held": np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0])}
    pair = paired(lost, loose, np.zeros(6, dtype=np.int32), other, 0)
    assert pair["not_held_rate"] == 0.0 and pair["there"]["not_held_rate"] == 0.4
    assert "not_held_rate" not in summary(lost, {}, 0), "nobody looked"


def test_worst_first_the_lost_then_the_loose_then_the_rough_then_the_hopeless() -> None:
    lost = np.array([0, 1, 0, 8, 2, 0], dtype=np.int32)
    time = np.array([2.0, 1.5, 2.0, 0.1, 0.5, 2.0])
    loose = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    deviation = np.array([0.1, 9.0, 0.3, 9.0, 9.0, np.nan])
    assert worst(lost, time, loose, deviation, 10) == [4, 1, 0, 2, 5, 3]
    assert worst(lost, time, loose, deviation, 2) == [4, 1]

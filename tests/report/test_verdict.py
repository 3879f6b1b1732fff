"""The verdict of a report, from results that are written by hand."""

import math
from dataclasses import replace
from typing import Any

import pytest

from sensorless.evaluation.results import Results
from sensorless.report.verdict import (
    MEASURES,
    Verdict,
    balance,
    best_rule,
    contrast,
    unsuited,
    verdict,
    wide_enough,
)
from sensorless.suitability.finding import Verdict as Suitability


def entry(lost: int = 0, size: int = 100, *, bound: bool = False) -> dict[str, Any]:
    rate = lost / size
    ends = {"lost_ci": (rate, rate + 0.02), "not_held_rate": 0.0, "not_held_rate_ci": (0.0, 0.02)}
    means = {"torque_dev_rms": 0.03, "torque_ripple_rms": 0.01}
    return {"bound": bound, "infeasible_rate": 0.0, "lost_rate": rate, **ends, **means}


def pair(**ours_minus_theirs: float) -> dict[str, Any]:
    """Differences of the first policy in percent of the other's means, sure to a tenth of that."""
    out: dict[str, Any] = {"there": {}}
    for m in MEASURES:
        change = 0.01 * ours_minus_theirs.get(m.key, 0.0)
        out[m.key] = -change  # results have the other minus the first
        spread = 0.1 * abs(change)
        out[f"{m.key}_ci"] = (-change - spread, -change + spread)
        out["there"][m.key] = 1.0 + change
    return out


def off(change: float, low: float, high: float, **others: float) -> dict[str, Any]:
    """A pair whose torque deviation changes so, with this interval, over the other's mean."""
    out = pair(**others)
    out["torque_dev_rms"], out["there"]["torque_dev_rms"] = -change, 1.0 + change
    out["torque_dev_rms_ci"] = (-high, -low)
    return out


def said_of(pairs: dict[str, dict[str, Any]]) -> Verdict:
    """Of a table, beside all of the others."""
    r = results(pairs)
    return verdict([r], [contrast(r, name) for name in pairs], True)


def results(pairs: dict[str, dict[str, Any]], lost: int = 0, *, bound: bool = False) -> Results:
    policies = {"mine": entry(lost, bound=bound), **{name: entry() for name in pairs}}
    return Results("stress-1", 1, 100, "paper", "", {}, {}, policies, pairs)


@pytest.mark.parametrize(
    ("pairs", "lost", "table", "word", "head"),
    [
        ({"eq25": pair(torque_dev_rms=-5.0)}, 0, True, "yes", "Flash it."),
        ({"eq25": pair(torque_dev_rms=-5.0, angle_err_rms_deg=3.0)}, 0, True, "with", "if you can"),
        ({"eq25": pair(torque_dev_rms=-0.5)}, 0, True, "no", "Do not"),
        ({"eq25": pair(torque_dev_rms=-1.5)}, 0, True, "yes", "Flash it."),
        ({"eq25": pair(torque_dev_rms=-5.0, lost_rate=2.0)}, 2, True, "no", "Do not"),
        ({"eq25": pair(torque_dev_rms=-5.0, not_held_rate=2.0)}, 0, True, "no", "Do not"),
        ({"eq25": pair(torque_dev_rms=-5.0)}, 5, True, "yes", "Flash it."),
        ({"eq25": pair(torque_dev_rms=-5.0)}, 6, True, "no", "Do not"),
        ({"eq25": pair(torque_dev_rms=-5.0)}, 0, False, "with", "Not as it is"),
        (
            {"eq25": pair(torque_dev_rms=-5.0), "linear-tuned": pair(torque_dev_rms=3.0)},
            0, True, "no", "Do not",
        ),
    ],
    ids=[
        "better", "mixed", "too little", "enough", "loses more", "holds fewer", "loses 5 %",
        "loses many", "network", "rule is better",
    ],
)  # fmt: skip
def test_verdict(
    pairs: dict[str, dict[str, Any]], lost: int, table: bool, word: str, head: str
) -> None:
    r = results(pairs, lost)
    said = verdict([r], [contrast(r, name) for name in pairs], table)
    assert said.word == word
    assert head in said.head


def test_a_rule_that_is_better_on_balance_is_named() -> None:
    pairs = {"eq25": pair(torque_dev_rms=-5.0), "linear-tuned": pair(torque_dev_rms=-1.5)}
    r = results(pairs)
    r.policies["linear-tuned"]["torque_dev_rms"] = 0.001
    said = verdict([r], [contrast(r, name) for name in pairs], True)
    assert said.word == "with" and said.head == "Flash it only if you cannot take linear-tuned."
    assert "on balance linear-tuned is better still" in said.because


@pytest.mark.parametrize(
    ("word", "head"),
    [("no", "Do not flash it."), ("with limits", "Flash it."), ("yes", "Flash it.")],
)
def test_it_is_not_flashed_on_a_machine_that_does_not_suit(word: str, head: str) -> None:
    r = results({"eq25": pair(torque_dev_rms=-5.0)})
    said = verdict([r], [contrast(r, "eq25")], True)
    found = unsuited(said, Suitability(word, ("it loses 70% of reversal", "it swings")))
    assert found.head == head and found.lines == said.lines
    assert ("because it loses 70% of reversal; it swings." in found.because) == (word == "no")


def test_the_plain_rule_is_not_refused_for_hops() -> None:
    r = results({"linear": pair(torque_dev_rms=-5.0)})
    r.policies["eq25"] = r.policies.pop("mine") | {"hops": 0.5}
    r.policies["linear"] = r.policies.pop("linear")
    assert "hops" not in verdict([r], [contrast(r, "linear")], True).because


def test_what_got_worse_is_said_with_its_size() -> None:
    r = results({"eq25": pair(torque_dev_rms=-5.0, angle_err_rms_deg=12.0)})
    said = verdict([r], [contrast(r, "eq25")], True)
    assert "Better than eq25: torque deviation −5 % on stress-1." in said.sentence
    assert "Worse than eq25: angle error +12 % on stress-1." in said.sentence


def test_one_of_many_comparisons_may_look_better_by_chance() -> None:
    """An interval of 95 % that barely excludes zero does not do, one that is far from it does."""
    for widths, word in ((1.2, "no"), (2.0, "yes")):
        half = 0.05 / widths
        said = said_of({"eq25": off(-0.05, -0.05 - half, -0.05 + half)})
        assert said.word == word
        assert ("one of 7 comparisons" in said.because) == (word == "no")
    assert wide_enough(1) == pytest.approx(1.0) and 1.3 < wide_enough(7) < 1.5


@pytest.mark.parametrize(("low", "high", "word"), [(-0.5, -0.03, "yes"), (-0.06, -0.005, "no")])
def test_a_change_is_sure_by_its_distance_from_zero(low: float, high: float, word: str) -> None:
    """5 % less: 2.5 and 1.1 times its interval on that side, of which 7 comparisons need 1.37."""
    assert said_of({"eq25": off(-0.05, low, high)}).word == word


BARELY = (-0.05, -0.092, -0.008)
"""Better by 1.2 times the half of the interval."""


def test_what_is_surely_worse_does_not_make_sure_of_what_is_better() -> None:
    said = said_of({"eq25": off(*BARELY, angle_err_rms_deg=20.0)})
    assert said.word == "no" and "Nothing is surely better than eq25" in said.because


def test_what_is_surely_better_than_a_rule_may_not_be_than_the_plain_one() -> None:
    said = said_of({"eq25": off(*BARELY), "linear-tuned": pair(torque_dev_rms=-9.0)})
    assert said.word == "no" and "one of 7 comparisons" in said.because


def test_a_rule_that_is_neither_better_nor_worse_is_not_to_be_taken_instead() -> None:
    """On balance it is worse."""
    r = results({"eq25": pair(torque_dev_rms=-5.0), "linear-tuned": pair()})
    r.policies["linear-tuned"]["torque_dev_rms"] = 0.05
    found = verdict([r], [contrast(r, name) for name in r.paired], True)
    assert found.word == "yes" and found.lines == (
        ("better", "Better than eq25: torque deviation −5 % on stress-1."),
    )


def test_a_change_of_a_mean_of_nothing_is_told_in_numbers() -> None:
    nothing = pair()
    nothing["there"]["overshoot_excess_pct"] = 0.0
    (found,) = (
        c
        for c in contrast(results({"eq25": nothing}), "eq25").changes
        if c.measure.key == "overshoot_excess_pct"
    )
    assert math.isnan(found.percent) and found.text == "0.00 % instead of 0.00 %"


def test_a_weight_that_hops_is_not_to_be_flashed() -> None:
    """Unless Eq. 25 does so there, too, as where a load drives the shaft at low speed."""
    for hops, plain, word in (
        (0.04, 0.0, "yes"),
        (0.17, 0.0, "no"),
        (0.17, 0.14, "yes"),
        (0.17, 0.13, "no"),
    ):
        r = results({"eq25": pair(torque_dev_rms=-5.0)})
        r.policies["mine"]["hops"], r.policies["eq25"]["hops"] = hops, plain
        said = verdict([r], [contrast(r, "eq25")], True)
        assert said.word == word and ("k_s hops" in said.because) == (word == "no")


def test_a_bound_is_not_to_be_flashed() -> None:
    r = results({"eq25": pair(torque_dev_rms=-50.0)}, bound=True)
    assert "cannot" in verdict([r], [contrast(r, "eq25")], True).head


def test_nothing_feasible_is_nothing_to_judge_by() -> None:
    r = results({"eq25": pair()})
    r.policies["mine"] |= {"infeasible_rate": 1.0, "lost_rate": math.nan}
    r.policies["eq25"] |= {"infeasible_rate": 1.0, "lost_rate": math.nan}
    assert "Nothing to judge" in verdict([r], [contrast(r, "eq25")], True).head


def test_few_scenarios_are_no_ground_for_a_verdict() -> None:
    """Two that differ alike have an interval without zero."""
    r = results({"eq25": pair(torque_dev_rms=-5.0)})
    r.policies["mine"]["infeasible_rate"] = 0.81
    said = verdict([r], [contrast(r, "eq25")], True)
    assert said.word == "no"
    assert said.sentence == (
        "Too few to judge by. 19 feasible scenarios of stress-1; give a larger --size."
    )


def test_few_machines_are_no_ground_for_a_verdict() -> None:
    """Their scenarios are alike, so 16 on each do not make up for them.

    Of 20 with 7 that can do any, 58 are needed for 20.
    """
    for able, size, said in (
        ([16] * 19, 19, "19 on which a scenario is feasible; give --size 320 or more."),
        ([16, 1, 0, 0] * 5, 20, "10 on which a scenario is feasible; give --size 640 or more."),
        ([16] * 7 + [0] * 13, 20, "7 on which a scenario is feasible; give --size 928 or more."),
        ([1] * 20, 20, None),
    ):
        r = replace(results({"eq25": pair(torque_dev_rms=-5.0)}), suite="machines", size=size)
        r.policies["mine"]["by_machine"] = {"feasible": able}
        found = verdict([r], [contrast(r, "eq25")], True)
        assert found.word == ("no" if said else "yes")
        assert found.head == ("Too few machines to judge by." if said else "Flash it.")
        assert said is None or found.because == said


def test_the_best_rule_is_a_tuned_one() -> None:
    r = results({"eq25": pair(), "linear-tuned": pair(), "gated-tuned": pair(), "x": pair()})
    r.policies["eq25"]["torque_dev_rms"] = r.policies["x"]["torque_dev_rms"] = 0.01
    r.policies["gated-tuned"]["torque_dev_rms"] = 0.02
    assert best_rule(r, list(r.policies)) == "gated-tuned"
    r.policies["gated-tuned"]["hops"] = 0.5  # none to flash
    assert best_rule(r, list(r.policies)) == "linear-tuned"
    assert best_rule(results({"eq25": pair()}), ["eq25"]) is None


def test_beside_another_control_nothing_is_better_or_worse() -> None:
    r = results({"eq25": pair(torque_dev_rms=-50.0, lost_rate=2.0), "linear-tuned": pair()})
    beside = contrast(r, "eq25", "--set speed_hz=1 --override")
    assert {change.word for change in beside.changes} == {""}
    said = verdict([r], [beside], True)
    assert said.word == "no" and said.sentence == (
        "Nothing to judge by. The control of eq25 is another, so its sensored twin is, too: add "
        "--set speed_hz=1 --override."
    )
    assert best_rule(r, list(r.policies), ["linear-tuned"]) is None
    assert balance(r, []).endswith("on stress-1): 4.00 %.")


def test_the_balance_is_the_objective() -> None:
    r = results({"eq25": pair()}, lost=1)
    assert balance(r, ["eq25"]).endswith("on stress-1): 14.00 %; eq25 4.00 %.")

"""Flash it or not: a policy's measures beside Eq. 25's and the best tuned rule's, in words."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import NormalDist
from typing import Any

from sensorless.envs.scenarios.machines_suite import SCENARIOS
from sensorless.evaluation.compare import hops_often
from sensorless.evaluation.objective import LOST_WEIGHT, weighted
from sensorless.evaluation.results import RATES, Results
from sensorless.evaluation.results_tables import number
from sensorless.export.judge import MOST_LOST
from sensorless.files import as_text
from sensorless.policies import shipped
from sensorless.suitability.finding import Verdict as Suitability

PLAIN = "eq25"
"""What a policy is compared with first, if it was judged."""
LEAST = 1.0
"""A change below this is called none, however sure it is [%]."""


@dataclass(frozen=True)
class Measure:
    """What is compared; less is better in every one."""

    key: str
    label: str
    factor: float
    unit: str
    decimals: int

    @property
    def is_rate(self) -> bool:
        """Whether it counts scenarios."""
        return self.key in RATES


MEASURES = (
    Measure("lost_rate", "lost", 100.0, " %", 1),
    Measure("not_held_rate", "not held", 100.0, " %", 1),
    Measure("torque_dev_rms", "torque deviation", 100.0, " %", 2),
    Measure("torque_ripple_rms", "torque ripple", 100.0, " %", 2),
    Measure("overshoot_excess_pct", "overshoot beyond the twin’s", 1.0, " %", 2),
    Measure("angle_err_rms_deg", "angle error", 1.0, "°", 2),
    Measure("injection_share", "injection on", 100.0, " %", 1),
)
FEWEST = 20
"""Feasible scenarios of a suite, or machines that can do any where it draws those, below which its
intervals are too narrow to judge by."""
BETTER, SAME, WORSE = "better", "same", "worse"


@dataclass(frozen=True)
class Change:
    """One measure of the policy beside another's, over the same scenarios."""

    measure: Measure
    here: str
    there: str
    percent: float
    """of the other's mean; NaN for rates, and where the other's is 0"""
    low: float
    high: float
    """its 95 % interval, likewise"""
    word: str
    """better, same or worse; empty beside another control"""
    widths: float = 0.0
    """how far the change is from 0, over the half of its interval on that side"""
    rates: tuple[tuple[float, ...], ...] = ()
    """value, low, high of both [%], if the measure counts scenarios"""

    @property
    def text(self) -> str:
        """How much it changed."""
        if self.measure.is_rate or not math.isfinite(self.percent):
            return f"{self.here} instead of {self.there}"
        return f"{self.percent:+.0f} %".replace("-", "−")


@dataclass(frozen=True)
class Contrast:
    """The policy beside one other on one suite."""

    suite: str
    other: str
    changes: tuple[Change, ...]
    control: str = ""
    """Options that give both one control; empty unless their sensored twins differ. With them no
    change has a word: it may be one of the twin."""

    @property
    def reach(self) -> float:
        """Half the width of a picture that shows all intervals [%]."""
        ends = [abs(x) for c in self.changes for x in (c.low, c.high) if math.isfinite(x)]
        return next((x for x in (2.0, 5.0, 10.0, 20.0, 50.0) if max(ends, default=0) <= x), 100.0)


@dataclass(frozen=True)
class Verdict:
    """What to do with the policy, and why."""

    word: str
    """yes, with or no"""
    head: str
    because: str = ""
    lines: tuple[tuple[str, str], ...] = ()
    """Better or worse, and what is."""

    @property
    def sentence(self) -> str:
        """All of it in one paragraph."""
        found = (text for _, text in self.lines)
        return " ".join(filter(None, (self.head, self.because, *found)))


def contrast(results: Results, other: str, control: str = "") -> Contrast:
    """Set the first policy of results beside another one; ``control`` as in ``Contrast``."""
    first = next(iter(results.policies))
    changes = tuple(_change(results, first, other, m) for m in MEASURES)
    if control:
        changes = tuple(replace(change, word="") for change in changes)
    return Contrast(results.suite, other, changes, control)


def contrasts_of(
    results: Sequence[Results], others: Sequence[str], controls: Mapping[str, str]
) -> list[Contrast]:
    """Beside every other policy on every suite; ``controls`` by name of those that need them."""
    return [contrast(r, other, controls.get(other, "")) for other in others for r in results]


def _change(results: Results, first: str, other: str, m: Measure) -> Change:
    pair = results.paired[other]
    change, base = -pair[m.key], pair["there"][m.key] + pair[m.key]
    low, high = (-x for x in reversed(pair[f"{m.key}_ci"]))
    sign = BETTER if high < 0.0 else WORSE if low > 0.0 else SAME
    half = high - change if change < 0.0 else change - low
    widths = abs(change) / half if half > 0.0 else 0.0 if change == 0.0 else math.inf
    if m.is_rate:
        sides = [results.policies[name] for name in (first, other)]
        total = feasible(results, sides[0])
        counts = [round(p[m.key] * feasible(results, p)) if total else 0 for p in sides]
        rates = [tuple(100.0 * x for x in (p[m.key], *p[RATES[m.key]])) for p in sides]
        nothing = (math.nan, math.nan, math.nan)
        here, there = f"{counts[0]} of {total}", f"{counts[1]}"
        return Change(m, here, there, *nothing, sign, widths, tuple(rates) if total else ())
    known = math.isfinite(base) and abs(base) > 1e-12
    share, low, high = (100.0 * x / base if known else math.nan for x in (change, low, high))
    here, there = (number(m.factor * x, m.decimals) + m.unit for x in (base + change, base))
    word = SAME if known and abs(share) < LEAST else sign
    return Change(m, here, there, share, low, high, word, widths)


def feasible(results: Results, policy: dict[str, float]) -> int:
    """Scenarios that the machine can do at all."""
    return round(results.count * (1.0 - policy["infeasible_rate"]))


def _too_few(results: Results, policy: dict[str, Any]) -> tuple[str, str] | None:
    """Head and reason of a verdict, if there is too little to judge by."""
    if "by_machine" in policy:
        able = sum(n > 0 for n in policy["by_machine"]["feasible"])
        enough = SCENARIOS * -(-FEWEST * results.size // max(able, 1))
        few = f"{able} on which a scenario is feasible; give --size {enough} or more."
        return ("Too few machines to judge by.", few) if able < FEWEST else None
    able = feasible(results, policy)
    few = f"{able} feasible scenarios of {results.suite}; give a larger --size."
    return ("Too few to judge by.", few) if able < FEWEST else None


def best_rule(results: Results, words: Sequence[str], apart: Collection[str] = ()) -> str | None:
    """The tuned rule of the lowest objective that may be flashed; None if none was judged.

    ``words`` name policies. A rule that hops too often beside the first other policy
    is none to take, nor is one of those with another control, ``apart``.
    """
    files = [as_text(Path(w).stem) for w in words if w.endswith(".json")]
    others = list(results.policies)[1:]
    able = [x for x in others if x in (*shipped.tuned_names(), *files) and x not in apart]
    found = [name for name in able if not hops(results, name, others[0])]
    return min(found, key=lambda name: _objective(results, name)) if found else None


def hops(results: Results, name: str, beside: str) -> bool:
    """Whether a policy moves k_s at rest too often beside another one."""
    own, theirs = (results.policies[x].get("hops", 0.0) for x in (name, beside))
    return name != PLAIN and hops_often(own, theirs)


def _objective(results: Results, name: str) -> float:
    p = results.policies[name]
    return float(weighted(p["lost_rate"], p["torque_dev_rms"], p["torque_ripple_rms"]))


def balance(results: Results, others: Sequence[str]) -> str:
    """Objective of the first policy and of others, in words."""
    first = next(iter(results.policies))
    told = [(n, f"{number(100.0 * _objective(results, n), 2)} %") for n in (first, *others)]
    (_, own), *rest = told
    return (
        f"On balance, by what training minimises ({LOST_WEIGHT:g} × lost + deviation + ripple, on "
        f"{results.suite}): {'; '.join(filter(None, (own, ', '.join(map(' '.join, rest)))))}."
    )


def verdict(results: Sequence[Results], contrasts: Sequence[Contrast], table: bool) -> Verdict:
    """Say what to do with the first policy of the results.

    Parameters
    ----------
    contrasts : sequence of Contrast
        Beside Eq. 25 first, on every suite; the best tuned rule may follow.
    table : bool
        It is a table, which a drive can hold.
    """
    name, first = next(iter(results[0].policies.items()))
    if first["bound"]:
        return Verdict("no", "It cannot be flashed.", f"{name} knows what no drive can know.")
    for r in results:
        p = r.policies[name]
        if not feasible(r, p):
            return Verdict("no", "Nothing to judge by.", f"No scenario of {r.suite} is feasible.")
        if not p["lost_rate"] <= MOST_LOST:
            lost = f"{round(p['lost_rate'] * feasible(r, p))} of {feasible(r, p)}"
            return Verdict("no", "Do not flash it.", f"It loses {lost} scenarios of {r.suite}.")
    for r in results:
        if few := _too_few(r, r.policies[name]):
            return Verdict("no", *few)
        if hops(r, name, contrasts[0].other):
            often = f"{r.policies[name]['hops']:.0%} of those of {r.suite} with rest"
            why = f"k_s hops, it moves at constant speed and load, in {often}."
            return Verdict("no", "Do not flash it.", why)
    plain, own = contrasts[0].other, _objective(results[0], name)
    if contrasts[0].control:
        why = f"The control of {plain} is another, so its sensored twin is, too: add"
        return Verdict("no", "Nothing to judge by.", f"{why} {contrasts[0].control}.")
    words: dict[str, set[str]] = {}
    for k in contrasts:
        words.setdefault(k.other, set()).update(c.word for c in k.changes)
    lines = tuple(
        (word, f"{word.capitalize()} than {other}: {text}.")
        for other in words
        for word in (BETTER, WORSE)
        if (text := _listed([k for k in contrasts if k.other == other], word))
    )
    loses = any(c.measure.is_rate and c.word == WORSE for k in contrasts for c in k.changes)
    if loses:
        return Verdict("no", "Do not flash it.", "It loses or does not hold more drives.", lines)
    if BETTER not in words[plain]:
        return Verdict("no", "Do not flash it.", f"Nothing is better than {plain}.", lines)
    looks = [c for k in contrasts if k.other == plain for c in k.changes]
    if not any(c.word == BETTER and c.widths >= wide_enough(len(looks)) for c in looks):
        why = f"Nothing is surely better than {plain}: one of {len(looks)} comparisons may look so."
        return Verdict("no", "Do not flash it.", why, lines)
    for other, found in words.items():
        if BETTER not in found and WORSE in found:
            why = f"Nothing is better than {other}: rather take that."
            return Verdict("no", "Do not flash it.", why, lines)
    if not table:
        why = "It is no table, and export writes tables; sensorless distill makes one of a network."
        return Verdict("with", "Not as it is.", why, lines)
    rules = [x for x in words if x != plain and _objective(results[0], x) < own]
    if rules:
        why = f"It is better than {plain}, but on balance {rules[0]} is better still."
        return Verdict("with", f"Flash it only if you cannot take {rules[0]}.", why, lines)
    if any(word == WORSE for word, _ in lines):
        return Verdict("with", "Flash it, if you can live with what got worse.", "", lines)
    return Verdict("yes", "Flash it.", "Nothing got worse.", lines)


def unsuited(said: Verdict, machine: Suitability) -> Verdict:
    """The same, or *no* where a check says that the machine does not suit with the policy."""
    if machine.word != "no":
        return said
    why = f"With it, the machine does not suit, because {'; '.join(machine.because)}."
    return Verdict("no", "Do not flash it.", why, said.lines)


def wide_enough(looks: int) -> float:
    """Least ``Change.widths`` of a change that is sure although it is one of so many.

    Bonferroni: one of ``looks`` intervals at a level of 1 - 0.05 / looks excludes zero by chance in
    5 % of the cases at most; such an interval of a normal distribution is this much wider than that
    of 95 %.
    """
    return NormalDist().inv_cdf(1.0 - 0.025 / looks) / NormalDist().inv_cdf(0.975)


def _listed(contrasts: Sequence[Contrast], word: str) -> str:
    """Measures of which a change has this word, each with how much on which suite."""
    found: dict[str, list[str]] = {}
    for k in contrasts:
        for c in k.changes:
            if c.word == word:
                found.setdefault(c.measure.label, []).append(f"{c.text} on {k.suite}")
    return "; ".join(f"{label} {', '.join(texts)}" for label, texts in found.items())

"""Whether a schedule is better than another one: a sentence, from scenarios that neither has seen.

Both run the same scenarios of ``SUITE``. The change of the objective gets a 95 % interval by
resampling scenarios, each with both results: *better* and *worse* are intervals that exclude zero.
A schedule that loses none has no loss to draw: the sentence says how rare one may be.
"""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.aggregate import Rows, interval_of
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.hop import hops
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.objective import Cost, cost_of, weighted
from sensorless.evaluation.rates import Bools, Interval
from sensorless.evaluation.rollout import Floats, rollouts, with_twin_to_the_end
from sensorless.plain_json import plain
from sensorless.policy import Policy

SUITE, SEED, SIZE = "stress-1", 97, 400
"""What is judged on; scenarios of the role ``test``, of a seed that no command has as its own."""
RULE_OF_THREE = 3
"""None lost of n scenarios: with 95 % confidence, the rate is at most 3 / n."""
OFTEN, OFTENER = 0.05, 1.25
"""Share of scenarios in which k_s hops from which on the verdict says so, and how many times that
of the other schedule it has to be: where the speed swings by the band of Eq. 25, that hops, too."""


def hops_often(ours: float, theirs: float) -> bool:
    """Whether k_s hops too often, from its share of scenarios and that of another schedule."""
    return ours > max(OFTEN, OFTENER * theirs)


@dataclass(frozen=True)
class Outcomes:
    """How n scenarios ended."""

    feasible: Bools
    """(n,) the sensored twin did what the scenario asks for"""
    lost: Bools
    """(n,)"""
    torque_dev: Floats
    """(n,) of those not lost, over rated torque; otherwise 0"""
    torque_ripple: Floats
    """(n,) likewise"""
    hops: Floats | None = None
    """(n,) 1 where k_s moves without a reason, NaN where no time shows it"""

    def cost(self, rows: Bools) -> Cost:
        """Cost over some scenarios."""
        return cost_of(self.lost, rows, self.torque_dev, self.torque_ripple)

    def objective(self, rows: Rows) -> Floats:
        """Value of ``OBJECTIVE`` (m,) over each of m draws of k scenarios (m, k)."""
        return weighted(*self._parts(rows))

    def _parts(self, rows: Rows) -> tuple[Floats, Floats, Floats]:
        lost = self.lost[rows]
        kept = np.sum(~lost, axis=-1)

        def mean(x: Floats) -> Floats:
            total = x[rows].sum(axis=-1) / np.maximum(kept, 1)
            return np.asarray(np.where(kept > 0, total, 1.0))

        rate = np.asarray(lost.sum(axis=-1) / max(lost.shape[-1], 1))
        return rate, mean(self.torque_dev), mean(self.torque_ripple)


def counted(feasible: int, size: int) -> str:
    """Number of scenarios in words."""
    return (
        f"{size} scenarios" if feasible == size else f"{feasible} feasible scenarios ({size} drawn)"
    )


def outcomes(
    policy: Policy, factories: Sequence[SimFactory], name: str, seed: int, size: int
) -> Outcomes:
    """Run ``size`` scenarios of a suite, rounded up to the same number on every machine."""
    share = -(-size // len(factories))
    return ended(
        policy, ((f, suite(name, f.motor, seed + i, share)) for i, f in enumerate(factories))
    )


def ended(policy: Policy, cases: Iterable[tuple[SimFactory, Scenarios]]) -> Outcomes:
    """Run the scenarios of each machine."""
    parts = []
    for factory, scenarios in cases:
        for r in rollouts(policy, scenarios, factory):
            kept = r.lost == 0
            dev, ripple = (
                np.where(kept, metric(r), 0.0) for metric in (torque_dev_rms, torque_ripple_rms)
            )
            whole = with_twin_to_the_end(r, factory, policy.settings)
            parts.append((whole.feasible, ~kept & whole.feasible, dev, ripple, hops(r)))
    return Outcomes(*(np.concatenate(column) for column in zip(*parts, strict=True)))


@dataclass(frozen=True)
class Comparison:
    """One schedule against another."""

    against: str
    """Name of the other one."""
    scenarios: int
    """Number of those that are feasible for both"""
    size: int
    """and of all."""
    ours: Cost
    theirs: Cost
    change: float
    """Objective, ours over theirs minus 1."""
    interval: Interval
    """95 %, of ``change``; NaN for fewer than two scenarios"""
    same: bool
    """Every scenario ended alike."""
    where: str = SUITE
    """What they are drawn from."""
    hops: float = 0.0
    """Share in which our k_s moves without a reason, of those with a time that shows it."""
    their_hops: float = 0.0
    """Share in which theirs does."""

    @property
    def word(self) -> str:
        """How it compares: same, better, worse or level, and level if nothing is feasible."""
        if self.same and self.scenarios:
            return "same"
        low, high = self.interval
        return "better" if high < 0.0 else "worse" if low > 0.0 else "level"

    @property
    def sentence(self) -> str:
        """The verdict."""
        if not self.scenarios:
            return f"not to compare with {self.against}: no scenario of {self.where} is feasible"
        where = f"{counted(self.scenarios, self.size)} of {self.where} that it was not made on"
        ours, theirs = (round(cost.lost_rate * self.scenarios) for cost in (self.ours, self.theirs))
        if self.same:
            return f"the same as {self.against}: every one of {where} ends alike, {ours} lost"
        start = {
            "better": f"better than {self.against}",
            "worse": f"worse than {self.against}",
            "level": f"neither better nor worse than {self.against}",
        }[self.word]
        share, low, high = (100.0 * x for x in (self.change, *self.interval))
        rare = max(1, self.scenarios // RULE_OF_THREE)
        unseen = "" if ours else f", which may miss a loss rarer than 1 in {rare}"
        return (
            f"{self._hopping}{start}: objective {share:+.1f} % (95 % interval {low:+.1f} to "
            f"{high:+.1f} %), lost {ours} instead of {theirs} of {where}{unseen}"
        )

    @property
    def _hopping(self) -> str:
        if not hops_often(self.hops, self.their_hops):
            return ""
        share = f"{self.hops:.0%} of those with rest"
        return f"do not flash it: k_s hops, it moves at constant speed and load, in {share}; "

    def facts(self) -> dict[str, Any]:
        """All of it in JSON types."""
        values = asdict(self)
        values["interval"] = plain(self.interval)
        return {"verdict": self.sentence, "suite": values.pop("where"), "seed": SEED, **values}


def compare(
    policy: Policy, other: Policy, against: str, factories: Sequence[SimFactory]
) -> Comparison:
    """Judge a policy beside another one, named ``against`` in texts.

    Parameters
    ----------
    factories : sequence of SimFactory
        Machines that divide the scenarios among them; policies may bring settings of their own.
    """
    ours, theirs = (outcomes(p, factories, SUITE, SEED, SIZE) for p in (policy, other))
    return comparison(ours, theirs, against)


def comparison(ours: Outcomes, theirs: Outcomes, against: str, where: str = SUITE) -> Comparison:
    """Compare the outcomes of the same scenarios, drawn from ``where``."""
    feasible = ours.feasible & theirs.feasible
    rows = np.flatnonzero(feasible)

    def change(drawn: Rows) -> Floats:
        return ours.objective(rows[drawn]) / theirs.objective(rows[drawn]) - 1.0

    same = all(
        np.array_equal(getattr(ours, name), getattr(theirs, name))
        for name in ("lost", "torque_dev", "torque_ripple")
    )
    return Comparison(
        against,
        len(rows),
        len(feasible),
        ours.cost(feasible),
        theirs.cost(feasible),
        float(change(np.arange(len(rows)))) if len(rows) else 0.0,
        interval_of(change, len(rows), SEED),
        same,
        where,
        _share(ours, feasible),
        _share(theirs, feasible),
    )


def _share(who: Outcomes, feasible: Bools) -> float:
    shown = np.zeros(0) if who.hops is None else who.hops[feasible & ~np.isnan(who.hops)]
    return float(shown.mean()) if len(shown) else 0.0

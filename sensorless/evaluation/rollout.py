"""Runs drives under a policy from start to end and keeps the sums of every decision."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import (
    SIGNAL_N,
    SIM,
    Array,
    enumeration,
    sim_run,
    sim_signals,
    sums_matrix,
)
from sensorless.core.gains import gain_records
from sensorless.core.runs import Run
from sensorless.decision import decision_periods, decision_time
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.lock import LockWatch
from sensorless.machine.motor import Motor
from sensorless.policy import (
    NO_SETTINGS,
    Policy,
    Settings,
    Signals,
    checked,
    decide,
    decide_gains,
    gains_of,
)

CHUNK = 256
"""Scenarios at a time: with ``sums_t`` of 88 bytes, 2 s of them take 45 MB."""

MOST_DECISIONS = 2_000_000
"""Decisions of all drives together that are in memory at a time, 88 bytes each."""

SUMS = tuple(SIM["sums"].names or ())
"""Fields of ``sums_t``."""

Floats = NDArray[np.float64]

CAUSES = enumeration("LOST_")
"""Bits of ``Rollout.lost``, see ``core/sim/sim.h``: why a drive stopped before its end."""


def cause_of(lost: int) -> str | None:
    """Names of the set bits of ``CAUSES``, joined by +; None without any."""
    return "+".join(name for name, bit in CAUSES.items() if lost & bit) or None


def are_feasible(lost: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(n,) from bits of ``CAUSES``: the sensored twin did what the scenario asks for."""
    return np.asarray(lost & CAUSES["twin"] == 0)


@dataclass(frozen=True)
class Rollout:
    """What happened to n drives in up to d decisions."""

    motor: Motor
    scenarios: Scenarios
    sums: Array
    """(d, n) of ``sums_t``, or of some of its fields: sums over the periods of each decision, whose
    number is its ``n``; zero after the end of a drive"""
    lost: NDArray[np.int32]
    """(n,) bits of ``CAUSES``, 0 for a drive that reached the end"""
    periods: NDArray[np.int64]
    """(n,) PWM periods lived, up to the verdict of a lost drive"""
    lock: dict[str, Floats] = field(default_factory=dict, repr=False)
    """What drives noticed of lost lock, of ``LockWatch``; empty if they stopped there"""
    kept: dict[str, Array] = field(default_factory=dict, repr=False, compare=False)
    """Arrays that several metrics need, by name"""

    @property
    def decision_time(self) -> float:
        """Length of a decision [s]."""
        return decision_time(self.motor)

    @cached_property
    def alive(self) -> NDArray[np.bool_]:
        """(d, n): the drive moved in this decision."""
        return np.asarray(self.sums["n"] > 0.0)

    @cached_property
    def count(self) -> NDArray[np.float32]:
        """(d, n) periods of each decision; NaN after the end of a drive."""
        return np.where(self.alive, self.sums["n"], np.float32(np.nan))

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """(n,) as far as the run came, the sensored twin did what the scenario asks for."""
        return are_feasible(self.lost)

    def mean(self, name: str) -> NDArray[np.float32]:
        """(d, n) mean of a field of ``sums_t`` over each decision; NaN after the end of a drive."""
        if name not in self.kept:
            self.kept[name] = self.sums[name] / self.count
        return self.kept[name]

    def total(self, name: str) -> Floats:
        """(n,) mean of a field of ``sums_t`` over the life of each drive; NaN if it had none."""
        count = np.where(self.periods > 0, self.periods, np.nan)
        return np.asarray(self.sums[name].sum(axis=0, dtype=np.float64) / count)


def rollout(
    policy: Policy,
    scenarios: Scenarios,
    factory: SimFactory,
    *,
    go_on: bool = False,
    keep: tuple[str, ...] = SUMS,
) -> Rollout:
    """Run all scenarios at once, each beside its sensored twin.

    Drives stop when they are lost. With ``go_on`` they go on, so that ``lock`` can say what they
    do about it; all else is the same. ``keep`` names the fields of ``sums`` to keep.

    Raises
    ------
    UserError
        As ``weights``.
    """
    n = len(scenarios)
    periods = decision_periods(factory.motor)
    sims = factory.build(scenarios, sensored=policy.sensored, settings=policy.settings)
    sims["go_on"] = go_on and not policy.sensored
    watch = LockWatch(factory.motor, n)
    decisions = -(-int(sims["k_end"].max(initial=0)) // periods)
    sums = np.zeros((decisions, n), dtype=[(name, np.float32) for name in keep])
    now, rows = sums_matrix(sims), sums.view(np.float32).reshape(decisions, n, -1)
    kept = [(rows, now)]
    if keep != SUMS:  # column by column, which is faster than a list of columns
        kept = [(rows[:, :, i], now[:, SUMS.index(name)]) for i, name in enumerate(keep)]
    obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
    ranges = gains_of(policy)
    gains = gain_records(sims, ranges, decision_time(factory.motor)) if ranges else None
    run = Run(sims, periods, obs, gains)
    policy.reset(n)
    sim_signals(sims, obs)
    for j in range(decisions):
        k_s = weights(policy, obs.copy(), sims)
        if gains is not None:
            decide_gains(policy, obs.copy(), gains)
        run.decide(k_s)
        for row, x in kept:
            row[j] = x
        if go_on:
            watch.look(sims)
    lived = np.where(sims["lost"] != 0, sims["k_lost"], sims["k"]).astype(np.int64)
    lock = watch.scores(sims) if go_on else {}
    return Rollout(factory.motor, scenarios, sums, sims["lost"].copy(), lived, lock)


def weights(policy: Policy, obs: Signals, sims: Array) -> NDArray[np.float32]:
    """Weights (n,) that a policy wants at the signals (n, SIGNAL_N), 0 to 1.

    Raises
    ------
    UserError
        They have another shape, or one is not from 0 to 1.
    """
    return checked(decide(policy, obs, sims), (len(obs),), 0.0, f"policy {policy.name}: act")


def with_twin_to_the_end(
    r: Rollout, factory: SimFactory, settings: Settings = NO_SETTINGS
) -> Rollout:
    """The same, but where the drive was lost its twin has gone on alone to the scenario's end.

    So whether a scenario is feasible depends on no policy, only on the ``settings`` that it brings.
    """
    rows = np.flatnonzero((r.lost != 0) & r.feasible)
    if not len(rows):
        return r
    lost = r.lost.copy()
    lost[rows] |= twins_alone(factory, r.scenarios[rows], settings)["lost"] & CAUSES["twin"]
    return replace(r, lost=lost)


def twins_alone(
    factory: SimFactory,
    scenarios: Scenarios,
    settings: Settings,
    change: Callable[[Array], None] | None = None,
) -> Array:
    """Sensored twins at the end of their scenarios, an array of ``SIM`` (n,).

    ``change`` may alter them before the start.
    """
    sims = factory.build(scenarios, sensored=True, twin=False, settings=settings)
    if change is not None:
        change(sims)
    n = len(scenarios)
    obs, k_s = np.zeros((n, SIGNAL_N), dtype=np.float32), np.zeros(n, dtype=np.float32)
    sim_run(sims, int(sims["k_end"].max()), k_s, obs)
    return sims


def at_a_time(scenarios: Scenarios, motor: Motor) -> int:
    """How many scenarios fit into memory together: fewer of long ones."""
    decisions = max(1.0, float(scenarios.duration.max()) / decision_time(motor))
    return max(16, int(MOST_DECISIONS / decisions))


def rollouts(
    policy: Policy,
    scenarios: Scenarios,
    factory: SimFactory,
    chunk: int = CHUNK,
    *,
    go_on: bool = False,
    keep: tuple[str, ...] = SUMS,
) -> Iterator[Rollout]:
    """Run all scenarios in order, ``chunk`` of them at a time; all else as in `rollout`."""
    for first in range(0, len(scenarios), chunk):
        yield rollout(policy, scenarios[first : first + chunk], factory, go_on=go_on, keep=keep)

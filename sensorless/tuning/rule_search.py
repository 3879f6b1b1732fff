"""A search by CMA-ES for the parameters of a rule, on random scenarios.

Each generation draws new scenarios, the same for all its candidates, and fewer in which loads go,
where a rule that leaves injection too early comes near a loss. After every CHECK generations
the centre of the search is judged on a fixed set of scenarios drawn for tuning too; the result is
the best centre judged, or the start if none is better.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np

from sensorless.baselines.rule import Rule
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.objective import NEAR_SUITE, Cost, NearCost
from sensorless.evaluation.rollout import Floats
from sensorless.machine.motor import Motor
from sensorless.tuning.batch import costs, near_losses
from sensorless.tuning.evolution import evolution

if TYPE_CHECKING:
    from cma import CMAEvolutionStrategy

SUITE, ROLE = "stress-1", "tune"
NEAR_EVERY = 2
"""Scenarios of ``SUITE`` to one of ``NEAR_SUITE``."""
CHECK = 3
"""Generations between two judgements of the centre."""
NONE = NearCost(1.0, 1.0, 1.0, 1.0)
"""Cost before anything has been judged."""
SIGMA = 0.2
"""First step of the search, over the range of each parameter."""

Progress = Callable[[float, Cost], None]
"""Called with the share of the budget used and the best found so far."""


@dataclass
class RuleSearch:
    """State of the search."""

    rule: Rule
    factories: Sequence[SimFactory]
    engine: Engine
    seed: int
    batch: int
    """Scenarios that each candidate of a generation runs."""
    judged: int
    """Scenarios that a centre is judged on."""
    best: dict[str, float]
    best_cost: Cost = NONE
    start_cost: Cost = NONE
    used: float = 0.0
    """Time simulated so far [s], without that of the sensored twins."""
    generations: int = 0
    interrupted: bool = False


def search(
    state: RuleSearch,
    es: "CMAEvolutionStrategy",
    budget: float,
    length: float,
    progress: Progress | None,
) -> None:
    """Judge the start, then search within the budget; an interrupt ends it with its best.

    Parameters
    ----------
    es : CMAEvolutionStrategy
        From ``over_unit_cube``.
    budget : float
        Time that may be simulated [s].
    length : float
        Time that one scenario takes, with its share of those of ``NEAR_SUITE`` [s].

    Raises
    ------
    KeyboardInterrupt
        Before the start has been judged.
    """
    (state.best_cost,) = _costs(state, [state.best], 0, state.judged)
    state.start_cost = state.best_cost
    try:
        for share in _generations(state, es, budget, length):
            if progress is not None:
                progress(share, state.best_cost)
    except KeyboardInterrupt:
        state.interrupted = True


def _generations(
    state: RuleSearch, es: "CMAEvolutionStrategy", budget: float, length: float
) -> Iterator[float]:
    """Search until another generation and its judgement could exceed the budget; share used."""
    rule, last, end = state.rule, 0, False
    while not end:
        longest = (es.popsize * state.batch + state.judged) * length
        go_on = state.used + longest <= budget
        if go_on:
            points, values = _ask(es, rule)
            found = _costs(state, values, state.generations + 1, state.batch)
            es.tell(points, [cost.objective for cost in found])
            state.generations += 1
        end = not go_on or bool(es.stop())
        if (end or state.generations % CHECK == 0) and state.generations > last:
            last = state.generations
            centre = _decode(rule, es.result.xfavorite)
            if rule.allows(centre):
                _judge(state, centre)
        yield min(state.used / budget, 1.0)


def _costs(
    state: RuleSearch, values: Sequence[dict[str, float]], generation: int, n: int
) -> list[NearCost]:
    """Mean cost of every candidate over n scenarios, shared among the machines."""
    share, parts = n // len(state.factories), []
    for i, factory in enumerate(state.factories):
        policies = [state.rule.build(state.rule.name, v, factory.motor) for v in values]
        words = factory.motor, state.seed, generation
        part = generation_scenarios(*words, share, i)
        unload = generation_scenarios(*words, share // NEAR_EVERY, i, of=NEAR_SUITE)
        found, seconds = costs(policies, part, factory, state.engine)
        near, more = near_losses(policies, unload, factory, state.engine)
        state.used += seconds + more
        both = zip(found, near, strict=True)
        parts.append([(*astuple(cost), x) for cost, x in both])
    return [NearCost(*(float(x) for x in row)) for row in np.mean(parts, axis=0)]


def generation_scenarios(
    motor: Motor, seed: int, generation: int, n: int, machine: int = 0, *, of: str = SUITE
) -> Scenarios:
    """Scenarios of a generation, counted from 1; 0: the set that centres are judged on."""
    words = (seed, generation, machine) if machine else (seed, generation)
    return suite(of, motor, int(combine(*words)[0]) >> 1, n, ROLE)


def _judge(state: RuleSearch, values: dict[str, float]) -> None:
    """Keep these values if they cost less than the best so far."""
    (cost,) = _costs(state, [values], 0, state.judged)
    if cost.objective < state.best_cost.objective:
        state.best, state.best_cost = values, cost


def over_unit_cube(rule: Rule, values: Mapping[str, float], seed: int) -> "CMAEvolutionStrategy":
    """Search over the ranges of a rule's parameters, as a unit cube, from these numbers."""
    ranges = ((values[p.name], *p.search) for p in rule.parameters)
    start = [(value - low) / (high - low) for value, low, high in ranges]
    if len(start) == 1:  # the library needs two dimensions; the second has no effect
        start = [*start, 0.5]
    return evolution(np.clip(start, 0.02, 0.98).tolist(), SIGMA, seed)


def _ask(es: "CMAEvolutionStrategy", rule: Rule) -> tuple[list[Floats], list[dict[str, float]]]:
    """Candidates, each drawn until the rule accepts it: as points and as parameters."""
    points: list[Floats] = []
    while len(points) < es.popsize:
        x = es.ask(1)[0]
        if rule.allows(_decode(rule, x)):
            points.append(x)
    return points, [_decode(rule, x) for x in points]


def _decode(rule: Rule, x: Floats) -> dict[str, float]:
    """Parameters at a point of the unit cube, rounded as in the file."""
    values = {}
    for p, u in zip(rule.parameters, x, strict=False):
        low, high = p.search
        values[p.name] = float(f"{low + float(np.clip(u, 0.0, 1.0)) * (high - low):.6g}")
    return values

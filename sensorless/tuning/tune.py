"""Parameters of a hand-over rule by CMA-ES, on scenarios that neither training nor evaluation uses.

Each generation draws new scenarios, the same for all its candidates, and fewer in which loads go,
where a rule that leaves injection too early comes near a loss. After every CHECK generations
the centre of the search is judged on a fixed set of scenarios drawn for tuning too; the result is
the best centre judged, or the start if none is better. All time simulated counts against the
budget, except that of the sensored twins.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from sensorless.baselines.rule import Rule
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import check_seed, combine
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.objective import NEAR_OBJECTIVE, NEAR_SUITE, Cost, NearCost
from sensorless.evaluation.rollout import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, rule_named
from sensorless.policies.tuned import Tuned
from sensorless.tuning.batch import costs, near_losses
from sensorless.tuning.evolution import evolution
from sensorless.versions import versions

if TYPE_CHECKING:
    from cma import CMAEvolutionStrategy

SUITE, ROLE = "stress-1", "tune"
NEAR_EVERY = 2
"""Scenarios of ``SUITE`` to one of ``NEAR_SUITE``."""
CHECK = 3
"""Generations between two judgements of the centre."""
GENERATIONS = 30
"""Number of generations that the number of scenarios is chosen for."""
FEWEST_SCENARIOS, MOST_SCENARIOS = 8, 256
"""Scenarios that each candidate of a generation runs."""
NONE = NearCost(1.0, 1.0, 1.0, 1.0)
"""Cost before anything has been judged."""
SIGMA = 0.2
"""First step of the search, over the range of each parameter."""

Progress = Callable[[float, Cost], None]
"""Called with the share of the budget used and the best found so far."""


@dataclass
class _Search:
    """State of the search."""

    rule: Rule
    factories: Sequence[SimFactory]
    engine: Engine
    seed: int
    judged: int
    best: dict[str, float]
    best_cost: Cost = NONE
    start_cost: Cost = NONE
    used: float = 0.0
    generations: int = 0
    interrupted: bool = False


def tune(
    name: str,
    motor: Motor,
    design: DriveDesign,
    budget: float,
    seed: int,
    *,
    machines: int = 0,
    command: str = "",
    progress: Progress | None = None,
    engine: Engine = LOCAL,
) -> Tuned:
    """Tune a rule; the same arguments give the same result.

    Parameters
    ----------
    name : str
        Name of a rule with parameters; with numbers behind a colon the search starts from them
        instead of the rule's own on this motor.
    budget : float
        Time that may be simulated [s].
    seed : int
        Seed of the scenarios, the search and the machines.
    machines : int
        Number of random machines to tune on instead of the motor, of which the search then only
        takes its start, and the speeds in r/min that it tells. 0: the motor.
    command : str
        Command line, kept in the provenance.
    engine : Engine
        Where the scenarios run; the result is the same to the bit on every engine.

    Raises
    ------
    UserError
        The rule does not exist or has no parameters, its numbers, the seed or the budget are out of
        range, or the library cma is missing.
    KeyboardInterrupt
        Before the start has been judged; later, an interrupt ends the search with its best.
    """
    word, _, numbers = name.partition(":")
    rule = rule_named(word)
    if not rule.parameters:
        tunable = ", ".join(r.name for r in RULES.values() if r.parameters)
        raise UserError(f"rule: {name!r} has no parameters to tune; choose from {tunable}")
    check_seed(seed)
    seed = int(seed)  # JSON takes none of NumPy
    start = rule.parse(name, numbers or None, motor)
    drawn = Machines.of(motor, machines, seed)
    es = _cma(rule, start, seed)
    population = es.popsize
    length, near = (
        float(generation_scenarios(motor, seed, 0, 1, of=name).duration[0])
        for name in (SUITE, NEAR_SUITE)
    )
    length += near / NEAR_EVERY
    fewest = max(FEWEST_SCENARIOS, NEAR_EVERY * len(drawn.motors))
    least = (2 + CHECK) * population * fewest * length
    if not least <= budget <= 1e9:
        raise UserError(f"budget: {budget:g} s; give {least:g} to 1e9 s for {name}")
    units = 1 + GENERATIONS * (1 + 1 / CHECK)
    batch = _shared(np.clip(budget / (units * population * length), fewest, MOST_SCENARIOS), drawn)
    judged = population * batch

    factories = [SimFactory(motor, design) for motor in drawn.motors]
    search = _Search(rule, factories, engine, seed, judged, start)
    (search.best_cost,) = _costs(search, [search.best], 0, judged)
    search.start_cost = search.best_cost
    try:
        _run(search, es, batch, budget, length, progress)
    except KeyboardInterrupt:
        search.interrupted = True
    provenance = {
        "command": command,
        "policy": rule.spec(search.best, motor),
        "started_from": rule.spec(start, motor),
        **drawn.origin(),
        **record(design, drawn.one),
        "suite": SUITE,
        "near_suite": NEAR_SUITE,
        "role": ROLE,
        "seed": seed,
        "objective": NEAR_OBJECTIVE,
        "budget_s": budget,
        "used_s": round(search.used, 3),
        "generations": search.generations,
        "population": population,
        "scenarios_per_candidate": batch,
        "scenarios_judged_on": judged,
        "interrupted": search.interrupted,
        "start": _scores(search.start_cost),
        "best": _scores(search.best_cost),
        "versions": {**versions(), "cma": version("cma")},
    }
    return Tuned(word, search.best, provenance)


def _run(
    search: _Search,
    es: "CMAEvolutionStrategy",
    batch: int,
    budget: float,
    length: float,
    progress: Progress | None,
) -> None:
    """Search until another generation and its judgement could exceed the budget."""
    rule, last = search.rule, 0
    while True:
        longest = (es.popsize * batch + search.judged) * length
        go_on = search.used + longest <= budget
        if go_on:
            points, values = _ask(es, rule)
            found = _costs(search, values, search.generations + 1, batch)
            es.tell(points, [cost.objective for cost in found])
            search.generations += 1
        end = not go_on or bool(es.stop())
        if (end or search.generations % CHECK == 0) and search.generations > last:
            last = search.generations
            centre = _decode(rule, es.result.xfavorite)
            if rule.allows(centre):
                _judge(search, centre)
        if progress is not None:
            progress(min(search.used / budget, 1.0), search.best_cost)
        if end:
            return


def _shared(batch: float, machines: Machines) -> int:
    """Scenarios of a candidate, rounded down to the same number on every machine."""
    n = len(machines.motors)
    return int(batch) // n * n


def _costs(
    search: _Search, values: Sequence[dict[str, float]], generation: int, n: int
) -> list[NearCost]:
    """Mean cost of every candidate over n scenarios, shared among the machines."""
    share, parts = n // len(search.factories), []
    for i, factory in enumerate(search.factories):
        policies = [search.rule.build(search.rule.name, v, factory.motor) for v in values]
        words = factory.motor, search.seed, generation
        part = generation_scenarios(*words, share, i)
        unload = generation_scenarios(*words, share // NEAR_EVERY, i, of=NEAR_SUITE)
        found, seconds = costs(policies, part, factory, search.engine)
        near, more = near_losses(policies, unload, factory, search.engine)
        search.used += seconds + more
        both = zip(found, near, strict=True)
        parts.append([(*astuple(cost), x) for cost, x in both])
    return [NearCost(*(float(x) for x in row)) for row in np.mean(parts, axis=0)]


def generation_scenarios(
    motor: Motor, seed: int, generation: int, n: int, machine: int = 0, *, of: str = SUITE
) -> Scenarios:
    """Scenarios of a generation, counted from 1; 0: the set that centres are judged on."""
    words = (seed, generation, machine) if machine else (seed, generation)
    return suite(of, motor, int(combine(*words)[0]) >> 1, n, ROLE)


def _judge(search: _Search, values: dict[str, float]) -> None:
    """Keep these values if they cost less than the best so far."""
    (cost,) = _costs(search, [values], 0, search.judged)
    if cost.objective < search.best_cost.objective:
        search.best, search.best_cost = values, cost


def _cma(rule: Rule, values: Mapping[str, float], seed: int) -> "CMAEvolutionStrategy":
    """Search over the unit cube, from these numbers."""
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


def _scores(found: Cost) -> dict[str, float]:
    return {**asdict(found), "objective": found.objective}

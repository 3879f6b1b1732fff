"""Parameters of a hand-over rule by CMA-ES, on scenarios that neither training nor judging sees.

Each generation meets scenarios of its own, the same for all its candidates. After every CHECK of
them the centre of the search is judged on a fixed set, from the same role; the best centre, or the
start, is the result. Time simulated counts against the budget wherever it is spent; the sensored
twins are not counted.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from sensorless.baselines.registry import RULES, rule_named
from sensorless.baselines.rule import Rule
from sensorless.baselines.tuned import Tuned
from sensorless.drive import DriveDesign
from sensorless.engine import LOCAL, Engine
from sensorless.envs.counter_random import combine
from sensorless.envs.scenario import Scenarios, SimFactory
from sensorless.errors import UserError
from sensorless.evaluate import versions
from sensorless.motor import Motor
from sensorless.objective import OBJECTIVE, Cost
from sensorless.rollout import Floats
from sensorless.suites import suite
from sensorless.tuning_batch import costs

SUITE, ROLE = "stress", "tune"
CHECK = 3
"""Generations from one judgement of the centre to the next."""
GENERATIONS = 30
"""Aimed at when the number of scenarios is chosen."""
LEAST, MOST = 8, 256
"""Scenarios of a candidate in a generation."""
SIGMA = 0.2
"""First step over the range of each parameter."""

Progress = Callable[[float, Cost, Cost], None]
"""Called with the share of the budget used, the best found so far, and the start."""


@dataclass
class _Search:
    """What is known so far."""

    rule: Rule
    motor: Motor
    factory: SimFactory
    engine: Engine
    best: dict[str, float]
    best_cost: Cost
    start_cost: Cost
    used: float
    generations: int = 0
    interrupted: bool = False


def tune(
    name: str,
    motor: Motor,
    design: DriveDesign,
    budget: float,
    seed: int,
    *,
    command: str = "",
    progress: Progress | None = None,
    engine: Engine = LOCAL,
) -> Tuned:
    """Tune a rule; the same arguments give the same result.

    Parameters
    ----------
    name : str
        Of a rule with parameters.
    budget : float
        Time that may be simulated [s].
    seed : int
        Draws scenarios and search.
    command : str
        For the provenance.
    engine : Engine
        Where the scenarios run; the result is the same to the bit.

    Raises
    ------
    UserError
        No such rule, one without parameters, a budget too small, or the library is missing.
    KeyboardInterrupt
        Only before there is a result; later it ends the search early.
    """
    rule = rule_named(name)
    if not rule.parameters:
        tunable = ", ".join(r.name for r in RULES.values() if r.parameters)
        raise UserError(f"rule: {name!r} has no parameters; allowed: {tunable}")
    es = _cma(rule, seed)
    population = es.popsize
    length = float(_scenarios(motor, seed, 0, 1).duration[0])
    least = (2 + CHECK) * population * LEAST * length
    if not least <= budget <= 1e9:
        raise UserError(f"budget: {budget:g} s; allowed for {name}: {least:g} to 1e9 s")
    units = 1 + GENERATIONS * (1 + 1 / CHECK)
    batch = int(np.clip(budget / (units * population * length), LEAST, MOST))
    judged = population * batch
    judges = _scenarios(motor, seed, 0, judged)

    factory = SimFactory(motor, design)
    start = rule.defaults()
    (cost,), used = costs([rule.build(name, start, motor)], judges, factory, engine)
    search = _Search(rule, motor, factory, engine, start, cost, cost, used)
    try:
        _run(search, es, judges, seed, batch, budget, progress)
    except KeyboardInterrupt:
        search.interrupted = True
    provenance = {
        "command": command,
        "policy": rule.spec(search.best, motor),
        "motor": motor.name,
        "motor_digest": motor.digest,
        "design": _plain(asdict(design)),
        "suite": SUITE,
        "role": ROLE,
        "seed": seed,
        "objective": OBJECTIVE,
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
    return Tuned(name, search.best, provenance)


def _run(
    search: _Search,
    es: Any,
    judges: Scenarios,
    seed: int,
    batch: int,
    budget: float,
    progress: Progress | None,
) -> None:
    """Generations until the budget could be exceeded, the last judgement included."""
    rule, motor, judged = search.rule, search.motor, float(judges.duration.sum())
    last = 0
    while True:
        part = _scenarios(motor, seed, search.generations + 1, batch)
        longest = es.popsize * float(part.duration.sum())
        go_on = search.used + longest + judged <= budget
        if go_on:
            points, values = _ask(es, rule)
            policies = [rule.build(rule.name, v, motor) for v in values]
            found, seconds = costs(policies, part, search.factory, search.engine)
            es.tell(points, [cost.objective for cost in found])
            search.used += seconds
            search.generations += 1
        end = not go_on or bool(es.stop())
        if (end or search.generations % CHECK == 0) and search.generations > last:
            last = search.generations
            centre = _decode(rule, es.result.xfavorite)
            if rule.allows(centre):
                _judge(search, centre, judges)
        if progress is not None:
            progress(min(search.used / budget, 1.0), search.best_cost, search.start_cost)
        if end:
            return


def _scenarios(motor: Motor, seed: int, generation: int, n: int) -> Scenarios:
    """Scenarios of a generation, from 1 on; 0 are those that the centres are judged on."""
    return suite(SUITE, motor, int(combine(seed, generation)[0]) >> 1, n, ROLE)


def _judge(search: _Search, values: dict[str, float], judges: Scenarios) -> None:
    """Keep these values if they are better than the best."""
    policy = search.rule.build(search.rule.name, values, search.motor)
    (cost,), seconds = costs([policy], judges, search.factory, search.engine)
    search.used += seconds
    if cost.objective < search.best_cost.objective:
        search.best, search.best_cost = values, cost


def _cma(rule: Rule, seed: int) -> Any:
    """Search over the unit cube, from the defaults."""
    try:
        import cma
    except ImportError:
        raise UserError(
            "tune needs the library cma; allowed: after pip install 'sensorless[tune]'"
        ) from None
    start = [(p.default - p.low) / (p.high - p.low) for p in rule.parameters]
    rng = np.random.default_rng(seed)
    options = {
        "bounds": [0.0, 1.0],
        "randn": lambda rows, columns: rng.standard_normal((rows, columns)),
        "seed": np.nan,
        "verbose": -9,
        "verb_log": 0,
        "tolflatfitness": 20,
    }
    if len(start) == 1:  # the library searches from two dimensions on: the second has no effect
        start = [*start, 0.5]
    return cma.CMAEvolutionStrategy(np.clip(start, 0.02, 0.98), SIGMA, options)


def _ask(es: Any, rule: Rule) -> tuple[list[Floats], list[dict[str, float]]]:
    """Candidates that the rule takes, each drawn again until it does."""
    points: list[Floats] = []
    while len(points) < es.popsize:
        x = es.ask(1)[0]
        if rule.allows(_decode(rule, x)):
            points.append(x)
    return points, [_decode(rule, x) for x in points]


def _decode(rule: Rule, x: Floats) -> dict[str, float]:
    """Parameters of a point of the unit cube, as they will stand in the file."""
    return {
        p.name: float(f"{p.low + float(np.clip(u, 0.0, 1.0)) * (p.high - p.low):.6g}")
        for p, u in zip(rule.parameters, x, strict=False)
    }


def _scores(found: Cost) -> dict[str, float]:
    return {**asdict(found), "objective": found.objective}


def _plain(design: dict[str, Any]) -> dict[str, Any]:
    """JSON has no infinity."""
    return {k: str(v) if v == np.inf else v for k, v in design.items()}

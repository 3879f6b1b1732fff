"""Parameters of a hand-over rule by CMA-ES, on scenarios that neither training nor evaluation uses.

All time simulated counts against the budget, except that of the sensored twins. ``rule_search`` has
the search itself.
"""

from dataclasses import asdict
from typing import Any

import numpy as np

from sensorless.baselines.rule import Rule
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import check_seed
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.objective import NEAR_OBJECTIVE, NEAR_SUITE, Cost
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, rule_named
from sensorless.policies.tuned import Tuned
from sensorless.tuning.rule_search import (
    CHECK,
    NEAR_EVERY,
    ROLE,
    SUITE,
    Progress,
    RuleSearch,
    generation_scenarios,
    over_unit_cube,
    search,
)
from sensorless.versions import LIBRARIES, versions

GENERATIONS = 30
"""Number of generations that the number of scenarios is chosen for."""
FEWEST_SCENARIOS, MOST_SCENARIOS = 8, 256
"""Scenarios that each candidate of a generation runs."""


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
    rule = _tunable(word, name)
    check_seed(seed)
    seed = int(seed)  # JSON takes none of NumPy
    start = rule.parse(name, numbers or None, motor)
    drawn = Machines.of(motor, machines, seed)
    es = over_unit_cube(rule, start, seed)
    length = _length(motor, seed)
    batch = _batch(name, budget, length, es.popsize, len(drawn.motors))
    factories = [SimFactory(motor, design) for motor in drawn.motors]
    found = RuleSearch(rule, factories, engine, seed, batch, es.popsize * batch, start)
    search(found, es, budget, length, progress)
    provenance = {
        "command": command,
        "policy": rule.spec(found.best, motor),
        "started_from": rule.spec(start, motor),
        **drawn.origin(),
        **record(design, drawn.one),
        "suite": SUITE,
        "near_suite": NEAR_SUITE,
        "role": ROLE,
        "seed": seed,
        "objective": NEAR_OBJECTIVE,
        "budget_s": budget,
        **_course(found, es.popsize),
        "versions": versions((*LIBRARIES, "cma")),
    }
    return Tuned(word, found.best, provenance)


def _tunable(word: str, name: str) -> Rule:
    """Rule of this word, if it has parameters."""
    rule = rule_named(word)
    if not rule.parameters:
        tunable = ", ".join(r.name for r in RULES.values() if r.parameters)
        raise UserError(f"rule: {name!r} has no parameters to tune; choose from {tunable}")
    return rule


def _length(motor: Motor, seed: int) -> float:
    """Time that one scenario takes, with its share of those of ``NEAR_SUITE`` [s]."""
    length, near = (
        float(generation_scenarios(motor, seed, 0, 1, of=name).duration[0])
        for name in (SUITE, NEAR_SUITE)
    )
    return length + near / NEAR_EVERY


def _batch(name: str, budget: float, length: float, population: int, machines: int) -> int:
    """Scenarios of a candidate that the budget [s] allows, the same number on every machine."""
    fewest = max(FEWEST_SCENARIOS, NEAR_EVERY * machines)
    least = (2 + CHECK) * population * fewest * length
    if not least <= budget <= 1e9:
        raise UserError(f"budget: {budget:g} s; give {least:g} to 1e9 s for {name}")
    units = 1 + GENERATIONS * (1 + 1 / CHECK)
    batch = np.clip(budget / (units * population * length), fewest, MOST_SCENARIOS)
    return int(batch) // machines * machines


def _course(found: RuleSearch, population: int) -> dict[str, Any]:
    """What the search used, and what it came from and to."""
    return {
        "used_s": round(found.used, 3),
        "generations": found.generations,
        "population": population,
        "scenarios_per_candidate": found.batch,
        "scenarios_judged_on": found.judged,
        "interrupted": found.interrupted,
        "start": _scores(found.start_cost),
        "best": _scores(found.best_cost),
    }


def _scores(found: Cost) -> dict[str, float]:
    return {**asdict(found), "objective": found.objective}

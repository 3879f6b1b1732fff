"""Search for lost scenarios inside a suite's ranges, by CMA-ES on the numbers it draws.

A search starts at the worst of some random scenarios and moves towards larger angle errors. Many
short searches from other starts find other failures; the random scenarios together say how often
sampling would find one.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.finds import Find, drawn, keys
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.rollout import Floats, rollout, with_twin_to_the_end
from sensorless.policy import Policy, require_runnable

SAMPLES = 128
"""Random scenarios at the start of a search."""
POPULATION = 64
SPREAD = 0.15
"""Of the first generation, in ranges of the numbers."""
GENERATIONS = 40
"""Most of a search."""
ENOUGH = POPULATION // 2
"""Lost scenarios of one generation at which a search ends."""
DIGITS = 6
"""Of a number: what is run is what the file holds."""


@dataclass
class Search:
    """What the searches found."""

    scenarios: int = 0
    """run in all"""
    lost: int = 0
    sampled: int = 0
    """of them at random"""
    sampled_lost: int = 0
    searches: int = 0
    finds: list[Find] = field(default_factory=list)
    """worst of each search"""
    interrupted: bool = False
    """by Ctrl-C, which keeps the searches that had ended"""


def severity(policy: Policy, scenarios: Scenarios, factory: SimFactory) -> tuple[Floats, Floats]:
    """How bad a scenario ends, and when it was lost.

    Returns
    -------
    severity : (n,)
        Largest angle error [deg] where lock is kept, 200 to 300 where it is lost, the more the
        earlier; 0 where the sensored twin fails too.
    lost_at : (n,)
        Time [s]; infinity where lock is kept.
    """
    r = with_twin_to_the_end(rollout(policy, scenarios, factory), factory, policy.settings)
    lost = r.lost != 0
    time = r.periods * factory.motor.T_s
    kept = np.nan_to_num(METRICS["angle_err_max_deg"](r))
    score = np.where(lost, 200.0 + 100.0 * (1.0 - time / scenarios.duration), kept)
    return np.where(r.feasible, score, 0.0), np.where(lost & r.feasible, time, np.inf)


def search(
    policy: Policy,
    factory: SimFactory,
    suite: str,
    seed: int,
    budget: int,
    progress: Callable[[Search], None] | None = None,
    most: int | None = None,
) -> Search:
    """Search until ``budget`` scenarios were run, or ``most`` searches.

    Parameters
    ----------
    suite : str
        One of ``SEARCHED``.
    seed : int
        Another one searches elsewhere.

    Raises
    ------
    UserError
        The policy knows the truth, the library cma is missing, or as ``SuiteRows``.
    """
    require_runnable(policy)
    SuiteRows(suite, factory.motor, seed, budget)  # raises where these are no rows of a suite
    found, dims = Search(), len(keys(suite, factory.motor))
    try:
        while found.scenarios + SAMPLES <= budget and (most is None or found.searches < most):
            _one(found, policy, factory, suite, seed, budget, dims)
            if progress is not None:
                progress(found)
    except KeyboardInterrupt:
        if not found.searches:
            raise
        found.interrupted = True
    return found


def _one(
    found: Search,
    policy: Policy,
    factory: SimFactory,
    suite: str,
    seed: int,
    budget: int,
    dims: int,
) -> None:
    """One search: the worst of random scenarios, and from there by evolution."""
    try:
        import cma
    except ImportError:
        text = "falsify needs the library cma; run: pip install 'sensorless[tune]'"
        raise UserError(text) from None
    noise = int(combine(seed, found.searches)[0])
    rng = np.random.default_rng([seed, found.searches])

    def run(units: Floats, noise: int = noise) -> tuple[Floats, Floats]:
        seeds = np.full(len(units), noise, dtype=np.uint64)
        score, when = severity(policy, drawn(suite, factory.motor, seeds, units), factory)
        found.scenarios += len(units)
        found.lost += int(np.isfinite(when).sum())
        return score, when

    units = rng.random((SAMPLES, dims)).round(DIGITS).clip(0.0, 1.0 - 10.0**-DIGITS)
    before = found.lost
    score, when = run(units)
    found.sampled += SAMPLES
    found.sampled_lost += found.lost - before
    best = int(np.argmax(score))
    worst = score[best], when[best], units[best]
    evolution = cma.CMAEvolutionStrategy(units[best], SPREAD, _options(rng))
    for _ in range(GENERATIONS):
        if found.scenarios + POPULATION > budget:
            break
        asked = evolution.ask()
        units = np.clip(np.round(asked, DIGITS), 0.0, 1.0 - 10.0**-DIGITS)
        score, when = run(units)
        evolution.tell(asked, (-score).tolist())
        best = int(np.argmax(score))
        if score[best] > worst[0]:
            worst = score[best], when[best], units[best]
        if np.isfinite(when).sum() >= ENOUGH:
            break
    found.searches += 1
    found.finds.append(
        Find(suite, noise, tuple(worst[2].tolist()), float(worst[0]), _time(worst[1]))
    )


def _time(when: float) -> float | None:
    return float(when) if np.isfinite(when) else None


def _options(rng: np.random.Generator) -> dict[str, Any]:
    return {
        "bounds": [0.0, 1.0],
        "popsize": POPULATION,
        "randn": np.random.RandomState(int(rng.integers(1, 2**31))).randn,
        "seed": np.nan,  # leave NumPy's own generator alone
        "verbose": -9,
        "CMA_diagonal": True,
    }

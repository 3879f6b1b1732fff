"""Runs a suite of scenarios under several policies and collects the results."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows, scenario_word
from sensorless.errors import UserError
from sensorless.evaluation.aggregate import by_place, paired, summary, worst
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.lock import LOCK, lock_summary
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.metrics.place import QUADRANTS, SPEED_EDGES
from sensorless.evaluation.metrics.place import by_place as sums_by_place
from sensorless.evaluation.rates import Groups
from sensorless.evaluation.results import Results
from sensorless.evaluation.rollout import (
    CHUNK,
    Floats,
    Rollout,
    are_feasible,
    at_a_time,
    cause_of,
    rollouts,
    with_twin_to_the_end,
)
from sensorless.files import check_writable
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, design_for, knows_truth
from sensorless.versions import versions

Progress = Callable[[float], None]
"""Called from time to time with the share done, 0 to 1."""

PolicyProgress = Callable[[str, float], None]
"""Called with the name of a policy and the share of its scenarios done."""


WORST = 10
"""Scenarios of each policy that are listed as its worst."""
WORST_METRICS = ("torque_dev_rms", "angle_err_max_deg")


@dataclass(frozen=True)
class Scores:
    """One policy on n scenarios."""

    lost: NDArray[np.int32]
    """(n,) bits of ``CAUSES``"""
    time: Floats
    """(n,) time lived [s]"""
    metrics: dict[str, Floats]
    """(n,) each, all of ``METRICS``"""
    places: dict[str, Array]
    """(n, p) each, of ``metrics.place.by_place``"""
    lock: dict[str, Floats]
    """(n,) each, of ``LockWatch``"""


def evaluate(
    motor: Motor,
    design: DriveDesign,
    suite: str,
    seed: int,
    size: int,
    policies: Mapping[str, Policy],
    *,
    out: Path | None = None,
    every: bool = True,
    progress: PolicyProgress | None = None,
    engine: Engine = LOCAL,
) -> Results:
    """Run every policy over the same scenarios and compare each with the first one.

    Parameters
    ----------
    suite, seed, size
        As in ``sensorless.envs.scenarios.suites.suite``.
    policies : mapping
        Policies by name; each is compared with the first.
    out : Path, optional
        Results file to write; that it can be written is checked before the run.
    every : bool
        Write the numbers of every single scenario to the file.
    engine : Engine
        Where the scenarios run; the results are the same to the bit.

    Raises
    ------
    UserError
        Something requested does not exist or is out of its range.
    """
    check_writable(out, ending=".json")
    if not policies:
        raise UserError("policy: none given; give one or more")
    scenarios = SuiteRows(suite, motor, seed, size)
    factory = SimFactory(motor, design)
    scores = {}
    for name, policy in policies.items():
        report = None if progress is None else partial(progress, name)
        scores[name] = score(policy, scenarios, factory, report, engine)
    words = [scenario_word(suite, seed, i, size) for i in range(size)]
    results = results_of(
        scores, policies, design, (suite, seed, size), motor, scenarios.seed, words
    )
    if out is not None:
        results.write(out, every)
    return results


def results_of(
    scores: Mapping[str, Scores],
    policies: Mapping[str, Policy],
    design: DriveDesign,
    drawn: tuple[str, int, int],
    motor: Motor | Machines,
    seeds: Seeds,
    words: Sequence[str],
    groups: Groups | None = None,
) -> Results:
    """Results of all policies on n scenarios.

    Parameters
    ----------
    drawn : tuple
        Name of the suite, its seed and its size.
    seeds, words
        Seed of each scenario, and what replays it.
    groups
        Scenarios that belong together, see ``aggregate``.
    """
    suite, seed, size = drawn
    return Results(
        suite=suite,
        seed=seed,
        size=size,
        motor=motor.name,
        motor_digest=motor.digest,
        design=asdict(design),
        versions=versions(),
        policies={
            name: {
                "estimator": _estimator(policies[name], design),
                "own": _own(policies[name], design),
            }
            | _entry(s, seeds, words, seed, knows_truth(policies[name]), groups)
            for name, s in scores.items()
        },
        paired=_paired(scores, seed, groups),
    )


def score(
    policy: Policy,
    scenarios: Scenarios | SuiteRows,
    factory: SimFactory,
    progress: Progress | None = None,
    engine: Engine = LOCAL,
    chunk: int = CHUNK,
) -> Scores:
    """All metrics of a policy on every scenario, ``chunk`` scenarios at a time."""
    total = len(scenarios)
    chunks = (scenarios[first : first + chunk] for first in range(0, total, chunk))
    parts = []
    for part in engine.map(partial(score_chunk, policy, factory), chunks):
        parts.append(part)
        if progress is not None:
            progress(min(len(parts) * chunk / total, 1.0))
    return joined(parts)


def score_chunk(policy: Policy, factory: SimFactory, rows: Scenarios | SuiteRows) -> Scores:
    """All metrics of a policy on some scenarios."""
    scenarios = rows.draw() if isinstance(rows, SuiteRows) else rows
    runs = rollouts(policy, scenarios, factory, at_a_time(scenarios, factory.motor), go_on=True)
    return joined([_scores(with_twin_to_the_end(r, factory, policy.settings)) for r in runs])


def _scores(r: Rollout) -> Scores:
    metrics = {name: metric(r) for name, metric in METRICS.items()}
    time = np.asarray(r.periods * r.motor.T_s, dtype=np.float64)
    return Scores(r.lost, time, metrics, sums_by_place(r), r.lock)


def joined(parts: Sequence[Scores]) -> Scores:
    """Scores of several chunks in a row."""
    return Scores(
        np.concatenate([p.lost for p in parts]),
        np.concatenate([p.time for p in parts]),
        {name: np.concatenate([p.metrics[name] for p in parts]) for name in METRICS},
        {name: np.concatenate([p.places[name] for p in parts]) for name in parts[0].places},
        {name: np.concatenate([p.lock[name] for p in parts]) for name in LOCK},
    )


def _estimator(policy: Policy, design: DriveDesign) -> str | None:
    """Estimator that a policy runs on; None if it runs on the true angle."""
    return None if policy.sensored else design_for(policy, design).estimator


def _own(policy: Policy, design: DriveDesign) -> dict[str, Any]:
    """Settings that a policy brings and that differ from the design of the others."""
    known = asdict(design)
    return {k: v for k, v in asdict(design_for(policy, design)).items() if v != known[k]}


def _entry(
    s: Scores,
    seeds: Seeds,
    words: Sequence[str],
    seed: int,
    bound: bool,
    groups: Groups | None,
) -> dict[str, Any]:
    """Results of one policy."""
    survived = s.lost == 0
    return {
        "bound": bound,
        **summary(s.lost, s.metrics, seed, groups),
        **lock_summary(s.lock, s.lost, s.time),
        "by_quadrant": {"place": QUADRANTS, **by_place(s.places["quadrant"], survived, groups)},
        "by_speed": {
            "from_rated_speed": SPEED_EDGES,
            **by_place(s.places["speed"], survived, groups),
        },
        "worst": _worst(s, words),
        "scenarios": {
            "seed": seeds.tolist(),
            "lost": (~survived & are_feasible(s.lost)).tolist(),
            "lost_cause": [cause_of(int(bits)) for bits in s.lost],
            "time_s": s.time.tolist(),
            **{name: x.tolist() for name, x in s.lock.items()},
            **{name: x.tolist() for name, x in s.metrics.items()},
        },
    }


def _worst(s: Scores, words: Sequence[str]) -> list[dict[str, Any]]:
    """The worst scenarios, each with the word that replays it."""
    return [
        {
            "scenario": words[i],
            "lost_cause": cause_of(int(s.lost[i])),
            "not_held": bool(s.lost[i] == 0 and s.metrics["not_held"][i] > 0.0),
            "time_s": float(s.time[i]),
            "quadrant": next((q for q, x in zip(QUADRANTS, there, strict=True) if x), None),
            **{name: float(s.metrics[name][i]) for name in WORST_METRICS},
        }
        for i in worst(s.lost, s.time, s.metrics["not_held"], s.metrics["torque_dev_rms"], WORST)
        for there in [s.places["quadrant"]["lost"][i]]
    ]


def _paired(
    scores: Mapping[str, Scores], seed: int, groups: Groups | None
) -> dict[str, dict[str, Any]]:
    first, *others = scores
    ref = scores[first]
    return {
        name: {
            "with": first,
            **paired(scores[name].lost, scores[name].metrics, ref.lost, ref.metrics, seed, groups),
        }
        for name in others
    }

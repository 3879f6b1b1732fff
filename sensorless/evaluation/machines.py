"""Runs every policy on random machines, each with a design of its own: the suite ``machines``.

A schedule that was made on another machine runs as it is: its signals and speeds are shares of
rated ones. Losses and errors are also compared with the first policy's on the same machine. All
intervals are over machines, since scenarios on one machine resemble each other.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines_suite import NAME, SCENARIOS, judged, rows_on
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows, scenario_word
from sensorless.evaluation.aggregate import mean_interval
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.evaluate import PolicyProgress, Scores, joined, results_of, score_chunk
from sensorless.evaluation.rates import mean
from sensorless.evaluation.results import Results
from sensorless.evaluation.rollout import are_feasible
from sensorless.files import check_writable
from sensorless.machine.motor import Motor
from sensorless.policy import Policy

COMPARED = ("torque_dev_rms", "torque_ripple_rms")
AS_GOOD = 1.02
"""Largest ratio to the first policy's mean at which a policy counts as no worse on a machine."""


def evaluate_machines(
    design: DriveDesign,
    seed: int,
    size: int,
    policies_on: Callable[[Motor], Mapping[str, Policy]],
    *,
    out: Path | None = None,
    every: bool = True,
    progress: PolicyProgress | None = None,
    engine: Engine = LOCAL,
) -> Results:
    """Run every policy on ``size`` machines.

    Parameters
    ----------
    policies_on : callable
        From a machine to its policies by name, the same names on every machine; each is compared
        with the first.
    out, every, progress, engine
        As in ``evaluate``.

    Raises
    ------
    UserError
        No machine or too many, or as in ``evaluate``.
    """
    check_writable(out, ending=".json")
    machines = judged(seed, size)
    rows = [rows_on(motor, i, seed, size) for i, motor in enumerate(machines.motors)]
    factories = [SimFactory(motor, design) for motor in machines.motors]
    policies = [policies_on(motor) for motor in machines.motors]
    parts: dict[str, list[Scores]] = {name: [] for name in policies[0]}
    for name, found in parts.items():
        jobs = zip((p[name] for p in policies), factories, rows, strict=True)
        for scores in engine.map(_scored, jobs):
            found.append(scores)
            if progress is not None:
                progress(name, len(found) / size)
    results = results_of(
        {name: joined(found) for name, found in parts.items()},
        policies[0],
        design,
        (NAME, seed, size),
        machines,
        np.concatenate([r.seed for r in rows]),
        [scenario_word(NAME, seed, i, i + 1) for i in range(SCENARIOS * size)],
        np.repeat(np.arange(size), SCENARIOS),
    )
    first = next(iter(parts.values()))
    for name, found in parts.items():
        results.policies[name]["by_machine"] = {
            "machine": [motor.name for motor in machines.motors],
            **_by_machine(found),
        }
        if name in results.paired:
            results.paired[name]["by_machine"] = _beside(found, first, seed)
    if out is not None:
        results.write(out, every)
    return results


def _scored(job: tuple[Policy, SimFactory, SuiteRows]) -> Scores:
    return score_chunk(*job)


def _by_machine(parts: Sequence[Scores]) -> dict[str, list[Any]]:
    """Counts on each machine, and means over what it survived."""
    able = [are_feasible(s.lost) for s in parts]
    return {
        "feasible": [int(np.sum(a)) for a in able],
        "lost": [int(np.sum((s.lost != 0) & a)) for s, a in zip(parts, able, strict=True)],
        **{
            name: [mean(s.metrics[name][s.lost == 0]) for s in parts]
            for name in ("not_held", *COMPARED)
        },
    }


def _beside(parts: Sequence[Scores], first: Sequence[Scores], seed: int) -> dict[str, Any]:
    """Ratios to the first policy, machine by machine, over the scenarios that both survived.

    ``NAME`` is the geometric mean over the machines, with a 95 % bootstrap interval over machines;
    ``NAME_as_good`` the share of the machines where the ratio is at most ``AS_GOOD``.
    """
    out: dict[str, Any] = {}
    for name in COMPARED:
        ratios = np.array([_ratio(s, f, name) for s, f in zip(parts, first, strict=True)])
        known = np.log(ratios[np.isfinite(ratios) & (ratios > 0.0)])
        low, high = mean_interval(known, seed)
        out[name] = float(np.exp(mean(known)))
        out[f"{name}_ci"] = (float(np.exp(low)), float(np.exp(high)))
        out[f"{name}_as_good"] = mean(known <= np.log(AS_GOOD))
        out[f"{name}_ratios"] = ratios.tolist()
    return out


def _ratio(here: Scores, there: Scores, name: str) -> float:
    both = (here.lost | there.lost) == 0
    base = mean(there.metrics[name][both])
    return mean(here.metrics[name][both]) / base if base > 0.0 else np.nan

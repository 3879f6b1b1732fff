"""Lost and held only, on a million scenarios, with exact intervals; it can stop and go on."""

import hashlib
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.core.api import SIGNAL_N
from sensorless.design.carried import worded
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import NAME as FAMILY
from sensorless.envs.scenarios.machines_suite import EACH, NAME, SCENARIOS, machine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.certificate import Tally, read_tally, result, write
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.metrics.held import NEEDED, not_held
from sensorless.evaluation.rollout import Rollout, at_a_time, rollouts, with_twin_to_the_end
from sensorless.files import check_writable
from sensorless.machine.motor import Motor
from sensorless.policy import GainPolicy, Policy, design_for, gains_of, require_runnable
from sensorless.versions import versions

Job = tuple[Policy, SimFactory, int, SuiteRows]
"""Policy, machine and drive, index of the first scenario, and the scenarios."""
CHUNK = 512
"""Scenarios at a time; 2 s of them take 90 MB. Results do not depend on it."""
SAVE_EVERY = 20.0
"""Time between two states of the file [s]."""
PROBES = 256
"""Random signals on which a policy shows that it is the one of the file."""


def certify(
    policy: Policy,
    motor: Motor,
    design: DriveDesign,
    suite: str,
    seed: int,
    size: int,
    *,
    out: Path | None = None,
    engine: Engine = LOCAL,
    progress: Callable[[Tally, float], None] | None = None,
) -> dict[str, Any]:
    """Count lost scenarios and those not held.

    Parameters
    ----------
    out : Path, optional
        File of the result, written every ``SAVE_EVERY`` too. If it exists and is of the same run,
        its scenarios are not run again; ``size`` may be larger than it was.
    engine : Engine
        Where the scenarios run; the result is the same to the bit.
    progress : callable, optional
        Called with what is counted so far, and the time since the start [s].

    Returns
    -------
    dict
        The content of the file: ``scenarios``, ``infeasible``, ``lost``, ``not_held``, ``lost_ci``
        and ``not_held_ci`` as rates of the feasible scenarios, words of lost scenarios, and what
        was run.

    Raises
    ------
    UserError
        The file is of another run or cannot be written, the policy knows the truth, or as
        ``SuiteRows``.
    """
    rows, factory = SuiteRows(suite, motor, seed, size), SimFactory(motor, design)
    run = _identity(policy, motor, design, suite, seed, size)

    def jobs(done: int) -> Iterator[Job]:
        for first in range(done, size, CHUNK):
            yield policy, factory, first, rows[first : first + CHUNK]

    return _counted(run, jobs, size, out, engine, progress)


def certify_machines(
    policy_on: Callable[[Motor], Policy],
    design: DriveDesign,
    seed: int,
    size: int,
    *,
    out: Path | None = None,
    engine: Engine = LOCAL,
    progress: Callable[[Tally, float], None] | None = None,
) -> dict[str, Any]:
    """The same on the suite ``machines``, every ``SCENARIOS`` scenarios on another machine.

    ``policy_on``: from a machine to the policy. All else as in ``certify``.
    """
    SuiteRows(EACH, machine(seed, 0), seed, size)  # raises where these are no rows of a suite

    def jobs(done: int) -> Iterator[Job]:
        while done < size:
            motor = machine(seed, done // SCENARIOS)
            end = min(size, (done // SCENARIOS + 1) * SCENARIOS)
            rows = SuiteRows(EACH, motor, seed, size)[done:end]
            yield policy_on(motor), SimFactory(motor, design), done, rows
            done = end

    first = machine(seed, 0)
    run = _identity(policy_on(first), first, design, NAME, seed, size)
    run |= {"motor": f"random machines of {FAMILY}", "motor_digest": None}
    return _counted(run, jobs, size, out, engine, progress)


def _counted(
    run: dict[str, Any],
    jobs: Callable[[int], Iterator[Job]],
    size: int,
    out: Path | None,
    engine: Engine,
    progress: Callable[[Tally, float], None] | None,
) -> dict[str, Any]:
    """Count what ``jobs`` from a number of scenarios on yields; ``certify`` has the rest."""
    check_writable(out, ending=".json")
    tally = read_tally(out, run) if out is not None and out.exists() else Tally()
    if tally.scenarios > size:
        raise UserError(
            f"size: {size}, but {str(out)!r} has {tally.scenarios} scenarios already; give as many "
            "or more, or another file"
        )
    begin = saved = time.monotonic()
    try:
        for more in engine.map(_count, jobs(tally.scenarios)):
            tally = tally + more
            now = time.monotonic()
            if progress is not None:
                progress(tally, now - begin)
            if out is not None and now - saved > SAVE_EVERY:
                write(out, run, tally)
                saved = now
    finally:
        if out is not None:
            write(out, run, tally)
    return result(run, tally)


def _count(job: Job) -> Tally:
    policy, factory, first, rows = job
    scenarios = rows.draw()
    tally = Tally()
    some = at_a_time(scenarios, factory.motor)
    for r in rollouts(policy, scenarios, factory, some, keep=NEEDED):
        done = with_twin_to_the_end(r, factory, policy.settings)
        tally = tally + _tally(done, first + tally.scenarios)
    return tally


def _tally(r: Rollout, first: int) -> Tally:
    lost = (r.lost != 0) & r.feasible
    loose = (r.lost == 0) & (not_held(r) > 0.0)
    return Tally(
        scenarios=len(r.lost),
        infeasible=int(np.sum(~r.feasible)),
        lost=int(lost.sum()),
        not_held=int(loose.sum()),
        lost_at=tuple((first + np.flatnonzero(lost)).tolist()),
        not_held_at=tuple((first + np.flatnonzero(loose)).tolist()),
    )


def _identity(
    policy: Policy, motor: Motor, design: DriveDesign, suite: str, seed: int, size: int
) -> dict[str, Any]:
    """What a result depends on; the size only where a scenario depends on it."""
    require_runnable(policy)
    known = versions()
    obs = np.random.default_rng(1).uniform(-1.0, 1.0, (PROBES, SIGNAL_N)).astype(np.float32)
    policy.reset(PROBES)
    acts = np.ascontiguousarray(policy.act(obs)).tobytes()
    if isinstance(policy, GainPolicy) and gains_of(policy):
        acts += repr(sorted(gains_of(policy).items())).encode() + policy.act_gains(obs).tobytes()
    return {
        "policy": policy.name,
        "acts": hashlib.sha256(acts).hexdigest()[:16],
        "suite": suite if suite != "envelope" else f"envelope of {size}",
        "seed": seed,
        "motor": motor.name,
        "motor_digest": motor.digest,
        "design": worded(asdict(design_for(policy, design))),
        "versions": {name: known[name] for name in ("sensorless", "core")},
    }

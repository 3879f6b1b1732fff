"""Whether two policies have the same sensored twin, by which both are measured."""

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

from sensorless.design.words import text_of
from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
from sensorless.envs.scenarios.machines_suite import SCENARIOS, rows_on
from sensorless.envs.scenarios.machines_suite import judged as machines_of
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.rollout import twins_alone
from sensorless.policies.bench import Bench
from sensorless.policy import design_for


def other_control(
    bench: Bench, suites: Sequence[str], seed: int, size: int, words: Sequence[str]
) -> dict[str, str]:
    """Policies whose settings make another sensored twin than those of the first one.

    What is measured beside the twin, or judged by what it can do, says nothing of such a pair. The
    twins run the first scenarios of every suite and are compared to the bit, so no list of settings
    has to be kept: an estimator, say, is none of the twin's.

    Returns
    -------
    dict
        By name of the policy the options with which both have the first one's control.
    """
    out: dict[str, dict[str, Any]] = {}
    for suite in suites:
        on, rows = _first(bench, suite, seed, size)
        run = partial(_twin, SimFactory(on.motor, on.design), rows)
        known = {n: asdict(design_for(p, on.design)) for n, p in on.policies(words).items()}
        (_, ours), *others = known.items()
        own = run(ours)
        for name, theirs in others:
            if theirs != ours and run(theirs) != own:
                out.setdefault(name, {}).update(_apart(run, own, ours, theirs))
    return {
        name: " ".join([*(_option(*x) for x in found.items()), "--override"])
        for name, found in out.items()
    }


def _option(name: str, value: Any) -> str:
    return shlex.join(["--set", f"{name}={text_of(value)}"])


def _first(bench: Bench, suite: str, seed: int, size: int) -> tuple[Bench, Scenarios]:
    """The first scenarios of a suite, and the bench that they run on."""
    if suite != MACHINES:
        return bench, SuiteRows(suite, bench.motor, seed, size)[:SCENARIOS].draw()
    motor = machines_of(seed, 1).motors[0]
    return bench.on(motor), rows_on(motor, 0, seed, 1).draw()


def _apart(
    run: Callable[[Mapping[str, Any]], bytes],
    own: bytes,
    ours: Mapping[str, Any],
    theirs: Mapping[str, Any],
) -> dict[str, Any]:
    """Those of ``ours`` that move our twin, of which theirs are others; all if it takes more."""
    differ = [name for name in ours if ours[name] != theirs[name]]
    moving = {name: ours[name] for name in differ if run({**ours, name: theirs[name]}) != own}
    alike = run({**theirs, **moving}) == own
    return moving if alike else {name: ours[name] for name in differ}


def _twin(factory: SimFactory, scenarios: Scenarios, settings: Mapping[str, Any]) -> bytes:
    """Where the sensored twins end; nothing, if no drive can be designed with these settings."""
    try:
        return twins_alone(factory, scenarios, settings)["drive"]["y"].tobytes()
    except UserError:
        return b""

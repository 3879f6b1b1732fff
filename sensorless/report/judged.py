"""What a report judges on: any suite, the one of random machines too."""

from collections.abc import Sequence

from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
from sensorless.envs.scenarios.machines_suite import SCENARIOS
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.words import own_machine, scenario_from
from sensorless.evaluation.evaluate import PolicyProgress, evaluate
from sensorless.evaluation.machines import evaluate_machines
from sensorless.evaluation.results import Results
from sensorless.policies.bench import Bench


def judged(
    bench: Bench,
    suite: str,
    seed: int,
    size: int,
    words: Sequence[str],
    progress: PolicyProgress | None = None,
) -> Results:
    """Results of the policies ``words`` on at most ``size`` scenarios, but at least one machine."""
    if suite != MACHINES:
        chosen = bench.policies(words)
        return evaluate(bench.motor, bench.design, suite, seed, size, chosen, progress=progress)
    return evaluate_machines(
        bench.design,
        seed,
        max(1, size // SCENARIOS),
        lambda motor: bench.on(motor).policies(words),
        progress=progress,
    )


def case_of(bench: Bench, word: str) -> tuple[Bench, Scenarios]:
    """A scenario by its word, and the bench that it runs on."""
    own, word = own_machine(word)
    bench = bench if own is None else bench.on(own)
    return bench, scenario_from(word, bench.motor)

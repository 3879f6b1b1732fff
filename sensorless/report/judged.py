"""What a report judges on: any suite, the one of random machines too."""

from collections.abc import Sequence

from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
from sensorless.envs.scenarios.machines_suite import SCENARIOS
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.words import own_machine, scenario_from
from sensorless.evaluation.evaluate import PolicyProgress, evaluate
from sensorless.evaluation.machines import evaluate_machines
from sensorless.evaluation.results import Results
from sensorless.export.judge import machine_with
from sensorless.policies.bench import Bench
from sensorless.policy import Policy, design_for
from sensorless.report.verdict import Verdict, unsuited


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


def on_its_machine(
    said: Verdict, policy: Policy, bench: Bench, progress: PolicyProgress | None = None
) -> Verdict:
    """The verdict on a policy, or *no* where the check of an export says so of the machine with it.

    A verdict that is *no* already does without the check, which is of some 900 scenarios.
    """
    if said.word == "no":
        return said
    report = progress or (lambda name, done: None)
    report("motor check", 0.0)
    machine = machine_with(policy, bench.motor, design_for(policy, bench.design))
    report("motor check", 1.0)
    return unsuited(said, machine.examination.verdict)


def case_of(bench: Bench, word: str) -> tuple[Bench, Scenarios]:
    """A scenario by its word, and the bench that it runs on."""
    own, word = own_machine(word)
    bench = bench if own is None else bench.on(own)
    return bench, scenario_from(word, bench.motor)

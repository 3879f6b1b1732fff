"""Whether tuning made a rule better: the sentence it ends with."""

from dataclasses import replace

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.compare import compare
from sensorless.machine.motor import Motor
from sensorless.policies.registry import rule_named
from sensorless.policies.tuned import Tuned


def judged(found: Tuned, motor: Motor, design: DriveDesign, machines: int, seed: int) -> Tuned:
    """Add to the provenance how a tuned rule compares with the numbers it started from.

    Arguments as in ``tune``; both run in scenarios that tuning has not seen.
    """
    rule = rule_named(found.rule)
    start = str(found.provenance["started_from"])
    name = f"its start, {start}"
    if rule.spec(found.parameters, motor) == start:
        used = f"{found.provenance['used_s']:g} s simulated"
        facts: dict[str, object] = {
            "verdict": f"the same as {name}: nothing better was found in {used}"
        }
    else:
        drawn = Machines.of(motor, machines, seed)
        factories = [SimFactory(m, design) for m in drawn.motors]
        ours, theirs = (
            rule.build(rule.name, values, motor)
            for values in (found.parameters, rule.parse(start, start.partition(":")[2], motor))
        )
        facts = compare(ours, theirs, name, factories).facts()
    return replace(found, provenance={**found.provenance, "verdict": facts})

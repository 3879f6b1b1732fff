"""The search on random machines, one search on each: the suite ``machines``."""

import dataclasses
from collections.abc import Callable

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.finds import Find
from sensorless.envs.scenarios.machines_suite import EACH, machine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.falsify.minimise import minimise
from sensorless.falsify.search import SAMPLES, Search, search
from sensorless.machine.motor import Motor
from sensorless.policy import Policy


def search_machines(
    policy_on: Callable[[Motor], Policy],
    design: DriveDesign,
    seed: int,
    budget: int,
    progress: Callable[[Search], None],
) -> tuple[Search, list[Find]]:
    """Search until ``budget`` scenarios were run; and the lost ones, minimised on their machines.

    ``policy_on``: from a machine to the policy. Search i is on machine i of the suite.
    """
    all_of, lost = Search(), []
    while all_of.scenarios + SAMPLES <= budget:
        i = all_of.searches
        motor = machine(seed, i)
        policy, factory = policy_on(motor), SimFactory(motor, design)
        try:
            found = search(policy, factory, EACH, seed, budget - all_of.scenarios, most=1)
            finds = [dataclasses.replace(find, machine=(seed, i)) for find in found.finds]
            lost += minimise(policy, factory, finds)
        except KeyboardInterrupt:
            if not all_of.searches:
                raise
            all_of.interrupted = True
            break
        for name in ("scenarios", "lost", "sampled", "sampled_lost", "searches"):
            setattr(all_of, name, getattr(all_of, name) + getattr(found, name))
        all_of.finds += finds
        progress(all_of)
    return all_of, lost

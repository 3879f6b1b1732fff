"""What a lost scenario needs: everything else set to nominal while it is still lost."""

import dataclasses

import numpy as np

from sensorless.envs.scenarios.finds import REMOVABLE, Find, scenarios_of, without
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.falsify.search import severity
from sensorless.policy import Policy


def minimise(policy: Policy, factory: SimFactory, finds: list[Find]) -> list[Find]:
    """The lost ones, with ``nominal`` filled; finds of one suite. One pass, a field at a time."""
    finds = [find for find in finds if find.lost_at is not None]
    if not finds:
        return []
    kept = scenarios_of(finds, factory.motor)
    spared: list[list[str]] = [[] for _ in finds]
    for name in REMOVABLE:
        tried = without(kept, [name], factory.motor)
        _, when = severity(policy, tried, factory)
        lost = np.isfinite(when)
        for f in dataclasses.fields(kept):
            mine, new = getattr(kept, f.name), getattr(tried, f.name)
            rows = lost.reshape(-1, *([1] * (mine.ndim - 1)))
            setattr(kept, f.name, np.where(rows, new, mine))
        for i in np.flatnonzero(lost):
            spared[i].append(name)
    return [
        dataclasses.replace(find, nominal=tuple(names))
        for find, names in zip(finds, spared, strict=True)
    ]

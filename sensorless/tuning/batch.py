"""Several policies on the same scenarios at once, and the cost of each."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from typing import cast

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.core.gains import Values
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.objective import Cost, cost_of, nearness
from sensorless.evaluation.rollout import Floats, rollout, with_twin_to_the_end
from sensorless.policy import GainPolicy, Policy, Signals, decide, gains_of

DRIVES = 512
"""Most drives simulated at once, roughly."""


class SideBySide:
    """Policies in blocks of n rows: rows i n to (i + 1) n - 1 belong to policy i.

    All must bring the same settings and set the same gains.
    """

    name = "side by side"
    sensored = False

    def __init__(self, policies: Sequence[Policy]) -> None:
        self.policies = policies
        self.settings, self.ranges = policies[0].settings, gains_of(policies[0])
        if any(policy.settings != self.settings for policy in policies):
            raise ValueError("policies on different drives")
        if any(gains_of(policy) != self.ranges for policy in policies):
            raise ValueError("policies with different gains")
        self._n = 0

    def reset(self, n: int) -> None:
        """Give each policy its share of the n drives."""
        self._n = n // len(self.policies)
        for policy in self.policies:
            policy.reset(self._n)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,) of policies that do not see the simulated truth."""
        return self.act_knowing(obs, np.empty(len(obs)))

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights (n,); a policy that is not privileged does not see ``sims``."""
        parts = (decide(p, obs[b], sims[b]) for p, b in self._blocks())
        return np.concatenate(list(parts))

    def act_gains(self, obs: Signals) -> Values:
        """Values of the gains (n, GAIN_N)."""
        parts = (cast(GainPolicy, p).act_gains(obs[rows]) for p, rows in self._blocks())
        return np.concatenate(list(parts))

    def _blocks(self) -> Iterator[tuple[Policy, slice]]:
        n = self._n
        return ((p, slice(i * n, (i + 1) * n)) for i, p in enumerate(self.policies))


@dataclass(frozen=True)
class _Group:
    """Policies from ``row`` on, simulated on the scenarios from ``column`` on."""

    row: int
    column: int
    policies: Sequence[Policy]
    scenarios: Scenarios


def costs(
    policies: Sequence[Policy],
    scenarios: Scenarios,
    factory: SimFactory,
    engine: Engine = LOCAL,
) -> tuple[list[Cost], float]:
    """Cost of every policy over all scenarios, and the time simulated [s] without the twins."""
    (lost, feasible, dev, ripple, _), seconds = _table(policies, scenarios, factory, engine)
    parts = zip(lost > 0.0, feasible > 0.0, dev, ripple, strict=True)
    return [cost_of(*part) for part in parts], seconds


def near_losses(
    policies: Sequence[Policy],
    scenarios: Scenarios,
    factory: SimFactory,
    engine: Engine = LOCAL,
) -> tuple[list[float], float]:
    """Mean ``nearness`` of every policy over the feasible scenarios; the time simulated [s]."""
    (lost, feasible, _, _, angle_err), seconds = _table(policies, scenarios, factory, engine)
    near = np.maximum(lost, nearness(angle_err)) * feasible
    return (near.sum(axis=1) / np.maximum(feasible.sum(axis=1), 1.0)).tolist(), seconds


def _table(
    policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, engine: Engine
) -> tuple[Floats, float]:
    """What ``_run`` finds of every policy in all scenarios (5, policies, scenarios); time [s]."""
    found, seconds = np.zeros((5, len(policies), len(scenarios))), 0.0
    groups = list(_groups(policies, scenarios))
    for group, (time, part) in zip(groups, engine.map(partial(_run, factory), groups), strict=True):
        rows = slice(group.row, group.row + len(group.policies))
        found[:, rows, group.column : group.column + len(group.scenarios)] = part
        seconds += time
    return found, seconds


def _groups(policies: Sequence[Policy], scenarios: Scenarios) -> Iterator[_Group]:
    """All policies on all scenarios, in groups of about DRIVES drives that set the same gains."""
    for column in range(0, len(scenarios), DRIVES):
        part = scenarios[column : column + DRIVES]
        at_once = max(1, DRIVES // len(part))
        for _, alike in groupby(range(len(policies)), key=lambda j: gains_of(policies[j])):
            rows = list(alike)
            for row in rows[::at_once]:
                end = min(row + at_once, rows[-1] + 1)
                yield _Group(row, column, policies[row:end], part)


def _run(factory: SimFactory, group: _Group) -> tuple[float, Floats]:
    """Time simulated [s]; by policy and scenario what stands in ``found``."""
    shape = len(group.policies), len(group.scenarios)
    rows = np.tile(np.arange(shape[1]), shape[0])
    together = SideBySide(group.policies)
    r = rollout(together, group.scenarios[rows], factory)
    feasible = with_twin_to_the_end(r, factory, together.settings).feasible
    angle_err = r.sums["err_max"].max(axis=0, initial=0.0)
    found = (r.lost != 0, feasible, torque_dev_rms(r), torque_ripple_rms(r), angle_err)
    return float(r.periods.sum()) * factory.motor.T_s, np.stack(found).reshape(5, *shape)

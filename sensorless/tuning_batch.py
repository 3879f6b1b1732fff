"""Several policies on the same scenarios at once, and what each of them costs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sensorless.core_api import Array
from sensorless.envs.policy import Policy, Signals, decide, estimator_of
from sensorless.envs.scenario import Scenarios, SimFactory
from sensorless.metrics import torque_dev_rms, torque_ripple_rms
from sensorless.objective import Cost
from sensorless.rollout import Floats, rollout

DRIVES = 512
"""Drives at a time."""


class SideBySide:
    """Policies in blocks of rows: rows i n to (i + 1) n belong to policy i.

    All of them have to work on the same estimator.
    """

    name = "side by side"
    sensored = False
    privileged = True

    def __init__(self, policies: Sequence[Policy]) -> None:
        self.policies = policies
        (self.estimator,) = {estimator_of(policy) for policy in policies}
        self._n = 0

    def reset(self, n: int) -> None:
        """Each policy gets its share of the n drives."""
        self._n = n // len(self.policies)
        for policy in self.policies:
            policy.reset(self._n)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights of policies that need no truth, (n,)."""
        return self.act_knowing(obs, np.empty(len(obs)))

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights (n,); a policy that is not privileged does not see ``sims``."""
        n = self._n
        blocks = [slice(i * n, (i + 1) * n) for i in range(len(self.policies))]
        parts = (decide(p, obs[b], sims[b]) for p, b in zip(self.policies, blocks, strict=True))
        return np.concatenate(list(parts))


def costs(
    policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory
) -> tuple[list[Cost], float]:
    """Cost of every policy over all scenarios, and the time simulated [s]; twins do not count."""
    n, seconds = len(scenarios), 0.0
    alive = np.zeros((len(policies), n), dtype=np.bool_)
    dev, ripple = np.zeros(alive.shape), np.zeros(alive.shape)
    for column in range(0, n, DRIVES):
        part = scenarios[column : column + DRIVES]
        m = len(part)
        at_once = max(1, DRIVES // m)
        for row in range(0, len(policies), at_once):
            group = policies[row : row + at_once]
            r = rollout(SideBySide(group), part[np.tile(np.arange(m), len(group))], factory)
            seconds += float(r.periods.sum()) * factory.motor.T_s
            where = slice(row, row + len(group)), slice(column, column + m)
            shape = len(group), m
            alive[where] = (r.lost == 0).reshape(shape)
            dev[where] = torque_dev_rms(r).reshape(shape)
            ripple[where] = torque_ripple_rms(r).reshape(shape)
    return [
        Cost(float(np.mean(~kept)), _mean(x, kept), _mean(y, kept))
        for kept, x, y in zip(alive, dev, ripple, strict=True)
    ], seconds


def _mean(x: Floats, rows: NDArray[np.bool_]) -> float:
    """Mean over ``rows``; 1 if there is none."""
    return float(x[rows].mean()) if rows.any() else 1.0

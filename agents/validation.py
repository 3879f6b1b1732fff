"""The real objective of training, on scenarios of its own."""

from dataclasses import dataclass

import numpy as np

from sensorless.envs.policy import TablePolicy
from sensorless.envs.scenario import SimFactory
from sensorless.ks_table import KsTable
from sensorless.metrics import torque_dev_rms, torque_ripple_rms
from sensorless.rollout import rollouts
from sensorless.suites import suite

LOST_WEIGHT = 10.0
"""Worth of the lost rate beside torque deviation and ripple: lock comes first. On 512 scenarios one
more loss weighs as much as a third of a usual deviation."""


@dataclass(frozen=True)
class Validation:
    """Means over the survived scenarios, shares of rated torque, and the lost rate over all."""

    lost_rate: float
    torque_dev: float
    torque_ripple: float

    @property
    def objective(self) -> float:
        """10 lost_rate + torque_dev + torque_ripple, to be made small."""
        return LOST_WEIGHT * self.lost_rate + self.torque_dev + self.torque_ripple


def validate(table: KsTable, factory: SimFactory, size: int, seed: int = 0) -> Validation:
    """Run a table over ``size`` stress scenarios with the role ``tune``."""
    scenarios = suite("stress", factory.motor, seed, size, role="tune")
    lost, dev, ripple = [], [], []
    for r in rollouts(TablePolicy("validated", table), scenarios, factory):
        kept = r.lost == 0
        lost.append(~kept)
        dev.append(torque_dev_rms(r)[kept])
        ripple.append(torque_ripple_rms(r)[kept])
    means = (float(np.mean(np.concatenate(x))) if sum(map(len, x)) else 1.0 for x in (dev, ripple))
    return Validation(float(np.mean(np.concatenate(lost))), *means)

"""The same drive with a position sensor: a bound for any estimator, a check of the metrics."""

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.rule import Rule
from sensorless.policy import NO_SETTINGS, Settings, Signals


class Sensored:
    """Runs on the true angle; its k_s has no effect."""

    name = "sensored"
    sensored = True
    settings: Settings = NO_SETTINGS

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Zeros (n,)."""
        return np.zeros(len(obs), dtype=np.float32)


RULE = Rule(
    "sensored", "bound: the true angle, no estimator at all", lambda name, v, motor: Sensored()
)

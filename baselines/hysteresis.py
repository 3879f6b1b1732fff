"""Hard switch of the estimated speed with a gap, as the VESC firmware and many others ship it.

    k_s = 0       |omega_hat| >= high
    k_s = 1       |omega_hat| <= low
    k_s = as it was between the two

The drive's slew limit on k_s still applies.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.core_api import SIGNAL_NAMES
from sensorless.envs.policy import Signals

GAP = 0.05
"""Half width of the gap over its centre: VESC's +-5 %."""

SPEED = SIGNAL_NAMES.index("speed")


class Hysteresis:
    """Switch with memory, one bit a drive.

    A drive starts on injection, and returns to it when its speed signal is not a number.

    Parameters
    ----------
    name : str
    low, high : float
        Gap over rated speed [-], low < high.
    """

    sensored = False

    def __init__(self, name: str, low: float, high: float) -> None:
        self.name = name
        self.low, self.high = np.float32(low), np.float32(high)
        self._k_s = np.ones(0, dtype=np.float32)

    def reset(self, n: int) -> None:
        """Put n drives on injection."""
        self._k_s = np.ones(n, dtype=np.float32)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,), each 0 or 1."""
        speed = obs[:, SPEED]
        self._k_s[speed >= self.high] = 0.0
        self._k_s[~(speed > self.low)] = 1.0
        return self._k_s.copy()

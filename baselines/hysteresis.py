"""Hard switch at a threshold of the estimated speed, as VESC and many other firmwares ship it.

    k_s = 0       |omega_hat| >= high
    k_s = 1       |omega_hat| <= low
    k_s = unchanged   in the gap between the two

The drive's slew limit on k_s still applies.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.linear import EQ25_BAND, eq25_band
from sensorless.baselines.rule import Parameter, Rule, Values, speed
from sensorless.core.api import SIGNAL_NAMES
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings, Signals

GAP = 0.05
"""Half width of the gap over its centre: VESC's +-5 %."""


class Hysteresis:
    """Switch with one bit of memory per drive.

    A drive starts on injection and returns to it when its signal is not a number.

    Parameters
    ----------
    name : str
    low, high : float
        Gap in the signal's own unit, for the speed over rated speed [-]; low < high.
    signal : str
        Signal that is compared with the gap.
    """

    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(self, name: str, low: float, high: float, signal: str = "speed") -> None:
        self.name = name
        self.signal = SIGNAL_NAMES.index(signal)
        self.low, self.high = np.float32(low), np.float32(high)
        self._k_s = np.ones(0, dtype=np.float32)

    def reset(self, n: int) -> None:
        """Put n drives on injection."""
        self._k_s = np.ones(n, dtype=np.float32)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,), each 0 or 1."""
        x = obs[:, self.signal]
        self._k_s[x >= self.high] = 0.0
        self._k_s[~(x > self.low)] = 1.0
        return self._k_s.copy()


def _at(share: float, band: tuple[float, float]) -> float:
    return share * 0.5 * (band[0] + band[1])


def ends(down: str, up: str) -> tuple[Parameter, Parameter]:
    """Parameters of a rule with a gap, by default around the centre of Eq. 25's band.

    ``down``, ``up``: what happens there, for the help.
    """
    low, high = 1.0 - GAP, 1.0 + GAP
    return (
        speed("lo", _at(low, EQ25_BAND), (0.0, 0.9), down, on=lambda m: _at(low, eq25_band(m))),
        speed("hi", _at(high, EQ25_BAND), (0.02, 1.2), up, on=lambda m: _at(high, eq25_band(m))),
    )


def _build(name: str, v: Values, motor: Motor) -> Hysteresis:
    return Hysteresis(name, v["lo"], v["hi"])


RULE = Rule(
    "hysteresis",
    "hard switch, up at HI, down at LO [r/min]; by default the middle of eq25's band, +-5 %",
    _build,
    ends("switches down to injection", "switches up to the observer"),
    rising=(("lo", "hi"),),
)

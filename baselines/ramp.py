"""Time ramp after the crossing of a speed: k_s moves to its new end at a fixed rate.

    target = hard switch of the speed with a gap (see ``hysteresis``)
    k_s moves towards target by dt / ramp per decision of dt, whatever dt is

The drives of NXP and ST take 25 to 50 ms. The drive's slew limit on k_s still applies.
"""

from math import inf

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.hysteresis import Hysteresis, ends
from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.decision import decision_time
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings, Signals


class TimeRamp:
    """Switch with memory, and the weight that follows it.

    Parameters
    ----------
    name : str
    low, high : float
        Gap over rated speed [-], low < high.
    ramp : float
        Time from one end to the other, above 0 [s].
    decision : float
        Time between decisions [s]; ``follow`` changes it.
    """

    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(self, name: str, low: float, high: float, ramp: float, decision: float) -> None:
        self.name = name
        self._ramp = ramp
        self.follow(decision)
        self._switch = Hysteresis(name, low, high)
        self._k_s = np.ones(0, dtype=np.float32)

    def follow(self, decision: float) -> None:
        """Decide at another interval [s]."""
        self.step = np.float32(min(decision / self._ramp, 1.0))

    def reset(self, n: int) -> None:
        """Put n drives on injection."""
        self._switch.reset(n)
        self._k_s = np.ones(n, dtype=np.float32)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,)."""
        self._k_s += np.clip(self._switch.act(obs) - self._k_s, -self.step, self.step)
        return self._k_s.copy()


def _build(name: str, v: Values, motor: Motor) -> TimeRamp:
    return TimeRamp(name, v["lo"], v["hi"], 1e-3 * v["ramp"], decision_time(motor))


RULE = Rule(
    "ramp",
    "moves to its new end within RAMP ms once the speed passes HI upwards or LO downwards",
    _build,
    (
        *ends("starts down to injection", "starts up to the observer"),
        Parameter("ramp", 40.0, "ms", 0.1, inf, "from one end to the other", search=(20.0, 400.0)),
    ),
    rising=(("lo", "hi"),),
)

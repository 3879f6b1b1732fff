"""Gated state machine: hand over only while both estimators work and agree.

    INJECTION  k_s = 1. To UP at speed >= high after ``hold`` decisions in a row in which both are
               warm and |disagreement| <= gate; at speed >= force anyway.
    UP         k_s falls at 1 / ramp. Back to DOWN when |disagreement| > release or speed <= low;
               to OBSERVER at k_s = 0.
    OBSERVER   k_s = 0, injection off. To WAKE at speed <= (low + high) / 2.
    WAKE       k_s = WAKE_K_S: the injection runs at full amplitude, but the drive still follows
               the observer. To DOWN at speed <= low after ``hold`` decisions in a row of agreement
               within release, or at half of low anyway; back to OBSERVER at speed >= high.
    DOWN       k_s rises at 1 / ramp; to INJECTION at k_s = 1, to UP at speed >= force.

Warm: the answer to the injection is at least WARM_HF of its value without load, and the estimated
EMF is at least WARM_EMF of what the magnets induce at the estimated speed. The drive's core aligns
the idle estimator with the one in use. The libraries of MathWorks and ST hand over in this way.
"""

from math import inf

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.linear import EQ25_BAND, eq25_end
from sensorless.baselines.rule import Parameter, Rule, Values, speed
from sensorless.core.api import SIGNAL_NAMES
from sensorless.decision import decision_time
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings, Signals

INJECTION, UP, OBSERVER, WAKE, DOWN = range(5)
WAKE_K_S = np.float32(5e-4)
WARM_HF = 0.3
WARM_EMF = 0.5
FORCE = 0.5
"""Speed, over rated, from which the observer takes over in any case; no less than Eq. 25's end."""
DEG_30 = 30.0
"""What the value 1 of the signal ``disagreement`` stands for [degrees]."""

SPEED, DISAGREEMENT, EMF, HF = (
    SIGNAL_NAMES.index(name) for name in ("speed", "disagreement", "emf", "hf_amplitude")
)


class Gated:
    """The state machine above for n drives. A speed that is not a number means INJECTION.

    Parameters
    ----------
    name : str
    low, high, force : float
        Speeds over rated speed [-], low < high.
    gate, release : float
        Disagreement [30 degrees].
    hold, ramp : float
        Agreement in a row, and from one end to the other [s].
    decision : float
        Time between decisions [s]; ``follow`` changes it.
    """

    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(
        self,
        name: str,
        *,
        low: float,
        high: float,
        force: float,
        gate: float,
        release: float,
        hold: float,
        ramp: float,
        decision: float,
    ) -> None:
        self.name = name
        self.low, self.high, self.force = low, high, force
        self.gate, self.release, self._hold, self._ramp = gate, release, hold, ramp
        self.follow(decision)
        self.reset(0)

    def follow(self, decision: float) -> None:
        """Decide at another interval [s]."""
        self.hold = max(1, round(self._hold / decision))
        self.step = np.float32(min(decision / self._ramp, 1.0))

    def reset(self, n: int) -> None:
        """Put n drives on injection."""
        self.state = np.full(n, INJECTION, dtype=np.int8)
        self._agreed = np.zeros(n, dtype=np.int32)
        self._k_s = np.ones(n, dtype=np.float32)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,)."""
        v, gap = obs[:, SPEED], np.abs(obs[:, DISAGREEMENT])
        was = self.state
        warm = (obs[:, HF] >= WARM_HF) & (obs[:, EMF] >= WARM_EMF * v)
        agreed = warm & (gap <= np.where(was == WAKE, self.release, self.gate))
        self._agreed = np.where(agreed, self._agreed + 1, 0)
        ready = self._agreed >= self.hold
        slow, fast, forced = v <= self.low, v >= self.high, v >= self.force
        near, below = v <= 0.5 * (self.low + self.high), v <= 0.5 * self.low
        bad = ~forced & ((gap > self.release) | slow)
        moves = (
            (INJECTION, UP, (fast & ready) | forced),
            (UP, OBSERVER, self._k_s <= 0.0),
            (UP, DOWN, bad),
            (OBSERVER, WAKE, near),
            (WAKE, OBSERVER, fast),
            (WAKE, DOWN, (slow & ready) | below),
            (DOWN, INJECTION, self._k_s >= 1.0),
            (DOWN, UP, forced),
        )
        state = was.copy()
        for here, there, when in moves:
            state[(was == here) & when] = there
        state[~np.isfinite(v)] = INJECTION
        self._agreed[state != was] = 0
        self.state = state
        self._k_s[state == INJECTION] = 1.0
        self._k_s[state == UP] -= self.step
        self._k_s[state == DOWN] += self.step
        np.clip(self._k_s, 0.0, 1.0, out=self._k_s)
        self._k_s[state == OBSERVER] = 0.0
        self._k_s[state == WAKE] = WAKE_K_S
        return self._k_s.copy()


def _build(name: str, v: Values, motor: Motor) -> Gated:
    return Gated(
        name,
        low=v["lo"],
        high=v["hi"],
        force=v["force"],
        gate=v["gate"] / DEG_30,
        release=v["release"] / DEG_30,
        hold=1e-3 * v["hold"],
        ramp=1e-3 * v["ramp"],
        decision=decision_time(motor),
    )


RULE = Rule(
    "gated",
    "state machine: both estimators warm and agreed for HOLD ms, then a ramp of RAMP ms",
    _build,
    (
        speed("lo", EQ25_BAND[0], (0.03, 0.6), "way back to injection"),
        speed("hi", EQ25_BAND[1], (0.05, 0.9), "way up, if both agree", on=eq25_end),
        speed(
            "force",
            FORCE,
            (0.2, 1.5),
            "way up in any case",
            on=lambda motor: max(FORCE, eq25_end(motor)),
        ),
        Parameter("gate", 15.0, "deg", 0, inf, "agreement to begin with", search=(3.0, 60.0)),
        Parameter(
            "release", 30.0, "deg", 0, inf, "disagreement that ends a way up", search=(5.0, 90.0)
        ),
        Parameter("hold", 5.0, "ms", 0, inf, "agreement in a row", search=(1.0, 100.0)),
        Parameter("ramp", 50.0, "ms", 0.1, inf, "from one end to the other", search=(20.0, 300.0)),
    ),
    rising=(("lo", "hi"), ("lo", "force")),
)

"""Mistakes that are made when a drive is built in, and the bit of the check that shows each."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensorless.core.api import Array
from sensorless.core.bring_up import BUILT

Matrix = tuple[float, float, float, float]

SAME: Matrix = (1.0, 0.0, 0.0, 1.0)
INVERTED: Matrix = (-1.0, 0.0, 0.0, -1.0)
THIRD = 2.0 * math.pi / 3.0


def turned(angle: float) -> Matrix:
    """Every phase takes the place of another."""
    c, s = math.cos(angle), math.sin(angle)
    return c, -s, s, c


def mirrored(angle: float) -> Matrix:
    """Two phases change places."""
    c, s = math.cos(angle), math.sin(angle)
    return c, s, s, -c


def scaled(x: float) -> Matrix:
    """All by the same factor."""
    return x, 0.0, 0.0, x


def gains(a: float, b: float) -> Matrix:
    """Of the channels of phase a and of phase b."""
    return a, 0.0, (a - b) / math.sqrt(3.0), b


def stuck(phase: float) -> Matrix:
    """The leg of the phase at this angle keeps half a duty: its part of the voltage is missing."""
    c, s = math.cos(phase), math.sin(phase)
    return 1.0 - 2.0 / 3.0 * c * c, -2.0 / 3.0 * c * s, -2.0 / 3.0 * c * s, 1.0 - 2.0 / 3.0 * s * s


@dataclass(frozen=True)
class Mistake:
    """What stands between the core and the machine; the defaults are right."""

    shows: tuple[str, ...] = ()
    """Bits of the check, any of which names it."""
    current: Matrix = SAME
    """from the right sample to the one that the core gets, stator frame"""
    voltage: Matrix = SAME
    """from the core's voltage to the commanded one"""
    delay: float = 1.0
    """of the voltage after its sample [periods]"""
    compensated: float = 0.0
    """lost voltage that the PWM driver compensates, over what is lost"""

    def record(self, i_knee: float) -> Array:
        """Return it as ``built_t``, shape (1,).

        The driver's compensation is full from the current ``i_knee`` on [A].
        """
        out = np.zeros(1, dtype=BUILT)
        out["i_map"], out["u_map"] = self.current, self.voltage
        out["delay"], out["added"], out["inv_i_add"] = self.delay, self.compensated, 1.0 / i_knee
        return out


RIGHT = Mistake()


def _all() -> Iterator[tuple[str, Mistake]]:
    for delay in (0.0, 0.5, 1.5, 2.0):
        yield f"delay-{delay:g}", Mistake(("delay",), delay=delay)
    yield "current-sign", Mistake(("sign",), current=INVERTED)
    yield "voltage-sign", Mistake(("sign",), voltage=INVERTED)
    for name, angle in (("bc", 0.0), ("ab", THIRD), ("ca", -THIRD)):
        yield f"current-{name}-swapped", Mistake(("phases",), current=mirrored(angle))
        yield f"voltage-{name}-swapped", Mistake(("phases",), voltage=mirrored(angle))
    yield "current-phases-shifted", Mistake(("phases",), current=turned(-THIRD))
    yield "voltage-phases-shifted", Mistake(("phases",), voltage=turned(THIRD))
    yield "channel-a-sign", Mistake(("channel",), current=gains(-1.0, 1.0))
    yield "channel-b-sign", Mistake(("channel",), current=gains(1.0, -1.0))
    shows = ("scale", "current", "deaf", "wiring")
    for gain in (0.5, 1.5):
        yield f"channel-a-gain-{gain:g}", Mistake(shows, current=gains(gain, 1.0))
        yield f"channel-b-gain-{gain:g}", Mistake(shows, current=gains(1.0, gain))
    for name, phase in (("a", 0.0), ("b", THIRD), ("c", -THIRD)):
        yield f"duty-{name}-stuck", Mistake((*shows, "phases", "channel"), voltage=stuck(phase))
    for name, factor in DUTIES.items():
        yield f"duty-{name}", Mistake(shows, voltage=scaled(factor))
    for share in (0.9, 1.0, 1.1):
        yield f"compensated-{share:g}", Mistake(("dead_time",), compensated=share)


DUTIES = {
    "half": 0.5,  # u / (2 u_dc)
    "double": 2.0,  # u / (u_dc / 2)
    "root-3": math.sqrt(3.0),  # u / (u_dc / sqrt(3))
    "line": 1.0 / math.sqrt(3.0),  # a phase-to-phase voltage
    "two-thirds": 2.0 / 3.0,  # u / (3/2 u_dc), the six-step amplitude turned over
    "three-halves": 1.5,  # u / (2/3 u_dc)
    "power-invariant": math.sqrt(2.0 / 3.0),  # transformation of that kind
    "power-variant": math.sqrt(1.5),  # its inverse
}
"""Wrong duty formulas and the voltage that they give over the wanted one."""
MISTAKES = dict(_all())
"""By name. Both current channels and both legs swapped alike is none: the shaft turns the other
way round."""

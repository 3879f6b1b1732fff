"""Gains that a schedule may set besides k_s: their names, their ranges, and their records.

``core/drive/gains.h`` has what each of them changes and how.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import GAINS, Array, enumeration, lib

GAIN_N: int = lib.GAIN_N
GAIN_NAMES = tuple(enumeration("GAIN_"))
"""Names in the order of every array of gains."""

Values = NDArray[np.float32]
"""Values (n, GAIN_N) from -1 to 1; 0 is the static gain."""

RANGE = (
    "sensorless.core.gains.Gain(low, high, settle): factors on the static gain, low above 0 and at "
    "most 1, high at least 1, so that a parabola through 1 only rises between them, and settle "
    "above 0 [s], all finite"
)
"""A usable ``Gain``, for messages."""


@dataclass(frozen=True)
class Gain:
    """Range of one gain."""

    low: float
    """Factor on the static gain at the value -1; above 0. At 1, the value has no part below 0."""
    high: float
    """Factor at the value 1. At 1, the value has no part above 0."""
    settle: float = 0.01
    """Time constant with which the value follows the one wanted [s]; twice as fast as the signals
    of a schedule change."""

    @property
    def usable(self) -> bool:
        """Whether the range holds the static gain, and a value ever arrives."""
        if not all(isinstance(x, Real) for x in (self.low, self.high, self.settle)):
            return False
        ends = 0.0 < self.low <= 1.0 <= self.high < math.inf
        return ends and 0.0 < self.settle < math.inf and self.rises

    @property
    def rises(self) -> bool:
        """Whether every value has a factor of its own: high is at most 4 - 3 low, and the reverse.

        Unless one of them is 1: then the factor is a line.
        """
        x = self.limits(1e-3)
        return 2.0 * abs(x["bend"]) <= x["rise"]

    def limits(self, decision: float) -> dict[str, float]:
        """Fields of ``gain_limits_t`` with ``decision`` seconds from one decision to the next.

        The factor is a parabola through both ends and the static gain, or a line to one end.
        """
        down, up = 1.0 - self.low, self.high - 1.0
        both = down > 0.0 and up > 0.0
        return {
            "rise": 0.5 * (down + up) if both else down + up,
            "bend": 0.5 * (up - down) if both else 0.0,
            "least": -1.0 if down > 0.0 else 0.0,
            "most": 1.0 if up > 0.0 else 0.0,
            "pace": -math.expm1(-decision / self.settle),
        }


DEFAULT: Mapping[str, Gain] = {
    "observer": Gain(0.5, 2.0),
    "injection": Gain(0.5, 2.0),
    "l_q": Gain(0.8, 1.25),
    "amplitude": Gain(0.5, 1.0),
}
"""Range of each gain unless something else is asked for. The injection is never louder than static:
noise and losses that the machine was not judged for would come with it."""


def gain_records(sims: Array, gains: Mapping[str, Gain], decision: float) -> Array:
    """Records of ``GAINS`` (n,) with static gains, for drives (n,) of SIM before their start.

    Parameters
    ----------
    sims : array of SIM, shape (n,)
    gains : mapping of str to Gain
        Those that may change; the others stay static.
    decision : float
        Time from one decision to the next [s].
    """
    out = np.zeros(len(sims), dtype=GAINS)
    out["design"] = sims["control"]
    out["n"] = len(gains)
    for j, name in enumerate(ranks(gains)):
        out["which"][:, j] = GAIN_NAMES.index(name)
        for field, x in gains[name].limits(decision).items():
            out["limit"][field][:, j] = x
    return out


def ranks(gains: Iterable[str]) -> list[str]:
    """Names in the order in which gains come into force, one a period."""
    return sorted(gains, key=GAIN_NAMES.index)


def write_wanted(gains: Array, values: Values) -> None:
    """Write values (n, GAIN_N) into the field ``wanted`` of records of ``GAINS``."""
    if len(gains):
        wanted = gains["wanted"]
        for j, which in enumerate(gains["which"][0, : gains["n"][0]].tolist()):
            wanted[:, j] = values[:, which]

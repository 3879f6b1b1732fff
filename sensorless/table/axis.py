"""One axis of the schedule table, and numbers that float32 keeps unchanged."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_NAMES, lib
from sensorless.errors import UserError

MAX_NODES: int = lib.KS_TABLE_NODES


def decimal(x: float) -> float:
    """Return the shortest decimal number that rounds to the same float32 as ``x``."""
    return float(str(np.float32(x)))


def float32_in(name: str, x: Any, low: float, high: float) -> float:
    """Round ``x`` to float32 and check that it is in [low, high].

    Raises
    ------
    UserError
        It is not a number, not finite or out of range.
    """
    try:
        with np.errstate(over="ignore"):
            y = float(np.float32(x))
    except (TypeError, ValueError, OverflowError):
        y = math.nan
    if isinstance(x, (bool, str)) or not low <= y <= high:
        raise UserError(f"table: {name}: {x!r}; give a number from {low:g} to {high:g}")
    return y


@dataclass(frozen=True)
class Axis:
    """Evenly spaced nodes over one signal; beyond them the value at the edge applies."""

    signal: str
    """Name in ``SIGNAL_NAMES``."""
    lo: float
    """Signal at the first node, in the signal's own unit; rounded to float32."""
    hi: float
    """Signal at the last node; rounded to float32."""
    n: int
    """Nodes, at least 2."""

    def __post_init__(self) -> None:
        """Check and round.

        Raises
        ------
        UserError
            A field is out of its range.
        """
        if self.signal not in SIGNAL_NAMES:
            known = ", ".join(SIGNAL_NAMES)
            raise UserError(f"table: axis: {self.signal!r} is not a signal; choose from {known}")
        whole = isinstance(self.n, (int, np.integer)) and not isinstance(self.n, bool)
        if not whole or not 2 <= self.n <= MAX_NODES:
            raise UserError(
                f"table: axis {self.signal}: n: {self.n!r}; give 2 to {MAX_NODES} nodes"
            )
        object.__setattr__(self, "n", int(self.n))
        for name in ("lo", "hi"):
            value = float32_in(f"axis {self.signal}: {name}", getattr(self, name), -1e6, 1e6)
            object.__setattr__(self, name, value)
        if not self.hi - self.lo >= 1e-6:
            raise UserError(
                f"table: axis {self.signal}: lo, hi: {self.lo:g}, {self.hi:g}; give lo < hi"
            )

    @property
    def inv_step(self) -> np.float32:
        """Nodes per unit of the signal, as the firmware has it."""
        return np.float32((self.n - 1) / (self.hi - self.lo))

    @property
    def nodes(self) -> NDArray[np.float32]:
        """Signal at each node (n,)."""
        return np.linspace(self.lo, self.hi, self.n, dtype=np.float32)

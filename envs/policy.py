"""What chooses the weight k_s at every decision."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sensorless.ks_table import KsTable

Signals = NDArray[np.float32]


class Policy(Protocol):
    """A rule for n drives at once; row i of every array is drive i."""

    name: str
    sensored: bool
    """The drive runs on its true angle instead of an estimate, and k_s is without effect."""

    def reset(self, n: int) -> None:
        """Forget the past; n drives are about to start."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights wanted (n,), 0 to 1, at the signals (n, SIGNAL_N) of ``core/signals.h``."""


class TablePolicy:
    """A schedule table, looked up by the code that also runs on the target. It has no memory.

    Parameters
    ----------
    name : str
    table : KsTable
    """

    sensored = False

    def __init__(self, name: str, table: KsTable) -> None:
        self.name = name
        self.table = table

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Interpolated weights (n,)."""
        return self.table.evaluate(obs)

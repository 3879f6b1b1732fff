"""Curves of the estimated speed as tables."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sensorless.table.ks_table import Axis, KsTable

NODES = 65
"""Nodes of a curve. Between two of them, h = 1 / 64 of the band apart, a straight line replaces the
curve: off by at most h^2 / 8 max |f''|."""

Curve = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def speed_curve(curve: Curve, low: float, high: float) -> KsTable:
    """Table of ``curve(u)`` with u = 1 at ``low`` and 0 at ``high``.

    Parameters
    ----------
    curve : callable
        From u in [0, 1] to k_s in [0, 1].
    low, high : float
        Band over rated speed [-], low < high.
    """
    u = np.linspace(1.0, 0.0, NODES)
    values = np.clip(curve(u), 0.0, 1.0).astype(np.float32)
    return KsTable((Axis("speed", low, high, NODES),), values)

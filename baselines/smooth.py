"""Smooth curves of the estimated speed instead of a ramp, as tables.

    smoothstep   k_s = u^2 (3 - 2 u)                     a ramp without corners
    sine         k_s = sin(pi u / 2)                     leaves injection late, reaches 0 steeply
    quadratic    k_s = max(0, 1 - (omega_hat / corner)^2)   no lower threshold

with u = clip((hi - |omega_hat|) / (hi - lo), 0, 1). Sine weights are used in practice, for instance
in doi 10.1038/s41598-026-35994-5; the half wave (1 - cos(pi u)) / 2 is within 0.01 of the
smoothstep, so this is the quarter wave. Between two of the `NODES` nodes, h = 1 / 64 of the band
apart, a straight line replaces the curve and is off by at most h^2 / 8 max |f''|: 1.9e-4
(smoothstep), 7.6e-5 (sine), 6.1e-5 (quadratic).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.linear import EQ25_BAND, eq25_end, on_a_band
from sensorless.baselines.rule import Rule, Values, speed
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.axis import Axis
from sensorless.table.ks_table import KsTable

NODES = 65

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


def smoothstep_table(low: float, high: float) -> KsTable:
    """Table of the smoothstep for a band over rated speed [-]."""
    return speed_curve(lambda u: u * u * (3.0 - 2.0 * u), low, high)


def sine_table(low: float, high: float) -> KsTable:
    """Table of the quarter sine for a band over rated speed [-]."""
    return speed_curve(lambda u: np.sin(0.5 * np.pi * u), low, high)


def quadratic_table(corner: float) -> KsTable:
    """Table of the parabola; ``corner`` is where it ends, over rated speed [-]."""
    return speed_curve(lambda u: 1.0 - (1.0 - u) ** 2, 0.0, corner)


def _quadratic(word: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(word, quadratic_table(v["corner"]))


SMOOTHSTEP = on_a_band(
    "smoothstep", "u^2 (3 - 2 u), u from 1 at a speed of LO to 0 at HI [r/min]", smoothstep_table
)
SINE = on_a_band("sine", "sin(pi u / 2), u from 1 at a speed of LO to 0 at HI [r/min]", sine_table)
QUADRATIC = Rule(
    "quadratic",
    "1 - (speed / CORNER)^2, 0 from CORNER [r/min] on",
    _quadratic,
    (speed("corner", EQ25_BAND[1], (0.05, 1.5), "above it the observer alone", on=eq25_end),),
)

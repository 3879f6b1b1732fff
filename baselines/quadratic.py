"""Parabola of the estimated speed: no lower threshold.

    k_s = max(0, 1 - (omega_hat / omega_c)^2)

As a table it is off by at most 6.1e-5 (|f''| = 2).
"""

from sensorless.baselines.linear import EQ25_BAND
from sensorless.baselines.rule import Rule, Values, speed
from sensorless.baselines.shapes import speed_curve
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable


def quadratic_table(corner: float) -> KsTable:
    """Table of the rule; ``corner`` is omega_c over rated speed [-]."""
    return speed_curve(lambda u: 1.0 - (1.0 - u) ** 2, 0.0, corner)


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(name, quadratic_table(v["corner"]))


RULE = Rule(
    "quadratic",
    "1 - (speed / CORNER)^2",
    _build,
    (speed("corner", EQ25_BAND[1], 0.05, 1.5, "above it the sliding-mode observer alone"),),
)

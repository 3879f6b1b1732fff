"""Smoothstep of the estimated speed: a ramp without corners.

    k_s = u^2 (3 - 2 u),   u = clip((high - |omega_hat|) / (high - low), 0, 1)

As a table it is off by at most 1.9e-4 (max |f''| = 6).
"""

from sensorless.baselines.linear import EQ25_BAND
from sensorless.baselines.rule import Rule, Values, speed
from sensorless.baselines.shapes import speed_curve
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable


def smoothstep_table(low: float, high: float) -> KsTable:
    """Table of the rule for a band over rated speed [-]."""
    return speed_curve(lambda u: u * u * (3.0 - 2.0 * u), low, high)


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(name, smoothstep_table(v["lo"], v["hi"]))


RULE = Rule(
    "smoothstep",
    "u^2 (3 - 2 u) over the band LO to HI of the speed",
    _build,
    (
        speed("lo", EQ25_BAND[0], 0.0, 0.6, "below it injection alone"),
        speed("hi", EQ25_BAND[1], 0.05, 1.5, "above it the sliding-mode observer alone"),
    ),
    rising=(("lo", "hi"),),
)

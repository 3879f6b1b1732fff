"""Quarter of a sine of the estimated speed: leaves injection late, reaches the observer steeply.

    k_s = sin(pi u / 2),   u = clip((high - |omega_hat|) / (high - low), 0, 1)

Sine weights are in use, for instance in doi 10.1038/s41598-026-35994-5; the half wave
(1 - cos(pi u)) / 2 is within 0.01 of the smoothstep, so the quarter wave stands here. As a table it
is off by at most 7.6e-5 (max |f''| = pi^2 / 4).
"""

import numpy as np

from sensorless.baselines.linear import EQ25_BAND
from sensorless.baselines.rule import Rule, Values, speed
from sensorless.baselines.shapes import speed_curve
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable


def sine_table(low: float, high: float) -> KsTable:
    """Table of the rule for a band over rated speed [-]."""
    return speed_curve(lambda u: np.sin(0.5 * np.pi * u), low, high)


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(name, sine_table(v["lo"], v["hi"]))


RULE = Rule(
    "sine",
    "sin(pi u / 2) over the band LO to HI of the speed",
    _build,
    (
        speed("lo", EQ25_BAND[0], 0.0, 0.6, "below it injection alone"),
        speed("hi", EQ25_BAND[1], 0.05, 1.5, "above it the sliding-mode observer alone"),
    ),
    rising=(("lo", "hi"),),
)

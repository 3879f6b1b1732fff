"""Logistic schedule of speed, torque current and disagreement: seven numbers define a table.

    centre = speed + motoring max(i, 0) + regenerating max(-i, 0) + lead max(d, 0) + lag max(-d, 0)
    z      = 4 (centre - s) / (width (1 + spread |i|))
    k_s    = clip(1.04 / (1 + exp(-z)) - 0.02, 0, 1)

s, i and d are the signals speed, torque_current and disagreement. The rule is the table on AXES:
multilinear between its nodes, not logistic. Its numbers come from tuning; no drive ships it.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.linear import EQ25_BAND, eq25_band
from sensorless.baselines.rule import Parameter, Rule, Values, speed
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import even_at_standstill

AXES = (
    Axis("speed", 0.0, 1.2, 25),
    Axis("torque_current", -1.5, 1.5, 7),
    Axis("disagreement", -1.5, 1.5, 5),
)


def logistic_table(v: Values, axes: tuple[Axis, ...] = AXES) -> KsTable:
    """Table of the parameters of RULE; ``axes`` has the same signals as AXES."""
    s, i, d = np.meshgrid(*(a.nodes.astype(np.float64) for a in axes), indexing="ij")
    centre = (
        v["speed"]
        + v["motoring"] * np.maximum(i, 0.0)
        + v["regenerating"] * np.maximum(-i, 0.0)
        + v["lead"] * np.maximum(d, 0.0)
        + v["lag"] * np.maximum(-d, 0.0)
    )
    z = 4.0 * (centre - s) / (v["width"] * (1.0 + v["spread"] * np.abs(i)))
    k_s: NDArray[np.float64] = 1.04 / (1.0 + np.exp(-np.clip(z, -50.0, 50.0))) - 0.02
    values = np.clip(k_s, 0.0, 1.0).astype(np.float32)
    return KsTable(axes, even_at_standstill(values, axes))


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(name, logistic_table(v))


def _shift(name: str, meaning: str) -> Parameter:
    return Parameter(name, 0.0, "1", -10, 10, meaning, search=(-0.6, 0.6))


RULE = Rule(
    "logistic",
    "logistic of speed, torque current and disagreement as a table; made for tuning",
    _build,
    (
        speed(
            "speed",
            0.5 * sum(EQ25_BAND),
            (0.02, 0.9),
            "where k_s is one half, without load",
            on=lambda motor: 0.5 * sum(eq25_band(motor)),
        ),
        speed(
            "width",
            EQ25_BAND[1] - EQ25_BAND[0],
            (0.03, 1.5),
            "width of the band",
            low=0.001,
            on=lambda motor: eq25_band(motor)[1] - eq25_band(motor)[0],
        ),
        _shift("motoring", "shift of the centre [rated speed] at rated current, motoring"),
        _shift("regenerating", "shift of the centre [rated speed] at rated current, regenerating"),
        _shift("lead", "shift at 30 degrees of disagreement, injection ahead"),
        _shift("lag", "shift at 30 degrees of disagreement, injection behind"),
        Parameter("spread", 0.0, "1", 0, 10, "widening at rated current", search=(0.0, 2.0)),
    ),
)

"""Coarse table over speed, torque current and disagreement whose node values are the parameters.

Made for tuning: it shows what an optimiser finds without reinforcement learning. It starts as a
ramp over the whole speed axis.
"""

from itertools import product

import numpy as np

from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import even_at_standstill

AXES = (
    Axis("speed", 0.0, 0.75, 6),
    Axis("torque_current", -1.0, 1.0, 3),
    Axis("disagreement", -1.0, 1.0, 3),
)
SHAPE = tuple(axis.n for axis in AXES)


def _name(index: tuple[int, ...]) -> str:
    return "k_" + "_".join(map(str, index))


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    nodes = np.array([v[_name(index)] for index in np.ndindex(SHAPE)], dtype=np.float32)
    return TablePolicy(name, KsTable(AXES, even_at_standstill(nodes.reshape(SHAPE), AXES)))


def _node(index: tuple[int, ...]) -> Parameter:
    ramp = round(1.0 - index[0] / (SHAPE[0] - 1), 6)
    at = ", ".join(f"{a.signal} {a.nodes[j]:g}" for a, j in zip(AXES, index, strict=True))
    return Parameter(_name(index), ramp, "1", 0, 1, f"k_s at {at}", search=(0.0, 1.0))


RULE = Rule(
    "grid",
    f"table of {' x '.join(map(str, SHAPE))} nodes over {', '.join(a.signal for a in AXES)}; "
    "made for tuning",
    _build,
    tuple(_node(index) for index in product(*map(range, SHAPE))),
)

"""One weight at all times: 1 is injection alone, 0 the observer alone."""

import numpy as np

from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable


def constant_table(k_s: float) -> KsTable:
    """Table with the same weight ``k_s``, 0 to 1, at every node."""
    return KsTable((Axis("speed", 0.0, 1.0, 2),), np.full(2, k_s, dtype=np.float32))


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    return TablePolicy(name, constant_table(v["k"]))


RULE = Rule(
    "constant",
    "K at all times",
    _build,
    (Parameter("k", 0.5, "1", 0, 1, "weight of injection", search=(0.0, 1.0)),),
    needs_numbers=True,
)
HFI = Rule(
    "hfi",
    "injection alone: constant:1",
    lambda name, v, motor: TablePolicy(name, constant_table(1.0)),
)
SMO = Rule(
    "smo",
    "sliding-mode observer alone: constant:0 on it",
    lambda name, v, motor: TablePolicy(name, constant_table(0.0), {"estimator": "smo"}),
    estimator="smo",
)

"""A table whose nodes are the parameters."""

from collections.abc import Callable

import pytest

from sensorless.baselines.grid import RULE, SHAPE
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Signals, TablePolicy

PAPER = Motor.load("paper")


def test_starts_as_a_ramp(signals: Callable[..., Signals]) -> None:
    k_s = make_policy("grid", PAPER).act(
        signals(speed=[0.0, 0.25, 0.75, 1.0], torque_current=1, disagreement=-2)
    )
    assert k_s == pytest.approx([1.0, 2.0 / 3.0, 0.0, 0.0], abs=1e-6)


def test_a_parameter_is_its_node() -> None:
    policy = make_policy("grid:k_2_0_1=0.125", PAPER)
    assert isinstance(policy, TablePolicy)
    assert policy.table.values.shape == SHAPE
    assert policy.table.values[2, 0, 1] == 0.125
    assert policy.table.values[2, 0, 0] == policy.table.values[2, 2, 2]
    assert len(RULE.parameters) == policy.table.values.size

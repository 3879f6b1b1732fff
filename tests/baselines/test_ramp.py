"""The time ramp starts at the crossing and takes its time."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.ramp import RULE, TimeRamp
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.machine.motor import Motor
from sensorless.policy import Signals

PAPER = Motor.load("paper")


def test_it_takes_its_time_and_can_turn_around(signals: Callable[..., Signals]) -> None:
    policy = TimeRamp("ramp", 0.2, 0.3, 4e-3, 1e-3)
    policy.reset(2)
    path = [(0.25, 0.25), (0.31, 0.25), (0.31, 0.25), (0.19, 0.25), (0.25, 0.25), (0.31, 0.4)]
    k_s = [policy.act(signals(speed=v)).tolist() for v in path]
    assert [a for a, _ in k_s] == [1.0, 0.75, 0.5, 0.75, 1.0, 0.75]
    assert [b for _, b in k_s] == [1.0, 1.0, 1.0, 1.0, 1.0, 0.75]


def test_40_ms_are_40_decisions(signals: Callable[..., Signals]) -> None:
    policy = RULE.build("ramp", RULE.defaults(), PAPER)
    policy.reset(1)
    k_s = np.array([policy.act(signals(speed=1.0))[0] for _ in range(45)])
    assert k_s[:40] == pytest.approx(1.0 - np.arange(1, 41) / 40.0, abs=1e-5)
    assert k_s[40:] == pytest.approx(0.0, abs=1e-5)


def test_reset_forgets(signals: Callable[..., Signals]) -> None:
    policy = TimeRamp("ramp", 0.2, 0.3, 4e-3, 1e-3)
    policy.reset(1)
    policy.act(signals(speed=1.0))
    policy.reset(1)
    assert policy.act(signals(speed=0.25)).tolist() == [1.0]


def test_a_ramp_takes_its_time_at_any_decision_period() -> None:
    policy = TimeRamp("ramp", 0.2, 0.3, 40e-3, 1e-3)
    for decision in (1e-3, 5e-3, 20e-3):
        policy.follow(decision)
        policy.reset(1)
        fast = np.zeros((1, SIGNAL_N), dtype=np.float32)
        fast[0, SIGNAL_NAMES.index("speed")] = 0.5
        n = 1
        while policy.act(fast)[0] > 0.0:
            n += 1
        assert 40e-3 - 1e-9 <= n * decision <= 41e-3  # rounding may leave one more step of 1 ms

"""The hard switch remembers, each drive for itself."""

import numpy as np
import pytest

from sensorless.baselines.hysteresis import Hysteresis
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

SPEED = SIGNAL_NAMES.index("speed")


def run(policy: Hysteresis, speeds: list[list[float]]) -> list[list[float]]:
    """Weights for rows of speeds, one row a decision, one column a drive."""
    out = []
    for row in speeds:
        obs = np.zeros((len(row), SIGNAL_N), dtype=np.float32)
        obs[:, SPEED] = row
        out.append(policy.act(obs).tolist())
    return out


def test_switches_up_at_high_and_down_at_low() -> None:
    policy = Hysteresis("hysteresis", 0.2, 0.3)
    policy.reset(1)
    path = [0.0, 0.25, 0.29, 0.3, 0.31, 0.25, 0.21, 0.2, 0.25, 0.35]
    weights = run(policy, [[speed] for speed in path])
    assert [w for (w,) in weights] == [1, 1, 1, 0, 0, 0, 0, 1, 1, 0]


def test_each_drive_has_its_own_memory() -> None:
    policy = Hysteresis("hysteresis", 0.2, 0.3)
    policy.reset(3)
    weights = run(policy, [[0.4, 0.1, 0.25], [0.25, 0.25, 0.25]])
    assert weights[1] == [0, 1, 1]


def test_reset_forgets() -> None:
    policy = Hysteresis("hysteresis", 0.2, 0.3)
    policy.reset(1)
    assert run(policy, [[0.4], [0.25]]) == [[0], [0]]
    policy.reset(1)
    assert run(policy, [[0.25]]) == [[1]]


def test_what_is_returned_is_not_the_memory() -> None:
    policy = Hysteresis("hysteresis", 0.2, 0.3)
    policy.reset(1)
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    obs[:, SPEED] = 0.25
    policy.act(obs)[:] = 0.5
    assert policy.act(obs)[0] == 1.0


def test_a_speed_that_is_no_number_means_injection() -> None:
    policy = Hysteresis("hysteresis", 0.2, 0.3)
    policy.reset(1)
    assert run(policy, [[0.4], [np.nan]]) == [[0], [1]]


def test_by_default_it_switches_in_the_middle_of_the_papers_band() -> None:
    """300 to 400 r/min, and 5 % of its middle to either side, as VESC does."""
    policy = make_policy("hysteresis", Motor.load("paper"))
    assert isinstance(policy, Hysteresis)
    rpm = [1500.0 * float(x) for x in (policy.low, policy.high)]
    assert rpm == pytest.approx([0.95 * 350.0, 1.05 * 350.0])

"""The oracle takes the better estimator, and nobody mistakes it for a rule."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.oracle import WAKE_K_S, Oracle
from sensorless.core.api import SIM, Array
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, make_policy
from sensorless.policy import PrivilegedPolicy, Signals, decide


def drives(err_hfi: list[float], err_smo: list[float], injecting: bool = True) -> Array:
    """Drives whose last decision of 5 periods had these mean errors [rad]."""
    sims = np.zeros(len(err_hfi), dtype=SIM)
    sims["sums"]["n"] = 5.0
    sims["sums"]["err_hfi"] = 5.0 * np.array(err_hfi)
    sims["sums"]["err_smo"] = 5.0 * np.array(err_smo)
    sims["sums"]["injecting"] = 5.0 * injecting
    return sims


def test_the_error_of_the_blend_is_least(signals: Callable[..., Signals]) -> None:
    policy = Oracle("oracle", inertia=1e-3, wake=0.1)
    policy.reset(4)
    sims = drives([0.1, 0.3, -0.1, 0.0], [0.3, 0.1, 0.3, 0.4])
    k_s = decide(policy, signals(speed=[0.1] * 4), sims)
    assert k_s == pytest.approx([1.0, 0.0, 0.75, 1.0], abs=1e-3)
    blend = k_s[2] * -0.1 + (1.0 - k_s[2]) * 0.3
    assert blend == pytest.approx(0.0, abs=1e-3)


def test_estimators_that_agree_leave_the_weight(signals: Callable[..., Signals]) -> None:
    policy = Oracle("oracle", inertia=0.5, wake=0.1)
    policy.reset(1)
    decide(policy, signals(speed=0.1), drives([3.0], [0.0]))
    here = decide(policy, signals(speed=0.1), drives([0.01], [0.01]))
    assert here[0] == pytest.approx(0.0, abs=0.05)


def test_the_injection_sleeps_and_wakes(signals: Callable[..., Signals]) -> None:
    policy = Oracle("oracle", inertia=0.5, wake=0.1)
    policy.reset(2)
    k_s = decide(policy, signals(speed=[1.0, 1.0]), drives([0.2, 0.05], [0.05, 0.2], False))
    assert k_s == pytest.approx([0.0, WAKE_K_S])


def test_it_is_marked_and_cannot_run_on_signals(signals: Callable[..., Signals]) -> None:
    policy = make_policy("oracle", Motor.load("paper"))
    assert isinstance(policy, PrivilegedPolicy)
    with pytest.raises(ValueError, match="true angle"):
        policy.act(signals(speed=0.1))
    assert RULES["oracle"].doc.startswith("knows the true angle")


def test_no_other_rule_sees_the_truth() -> None:
    motor = Motor.load("paper")
    for name in RULES:
        policy = make_policy(f"{name}:0.5" if name == "constant" else name, motor)
        assert isinstance(policy, PrivilegedPolicy) == (name == "oracle")

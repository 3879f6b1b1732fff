"""The threshold from the machine's own numbers."""

from dataclasses import replace

import pytest

from sensorless.baselines.hysteresis import Hysteresis
from sensorless.baselines.physics_threshold import physics_speed
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

PAPER = Motor.load("paper")


def test_the_papers_motor_by_hand() -> None:
    volts = 0.2 * 2.484 * 6.8 + 540.0 * 2.0e-6 / 2.0e-4
    rpm = volts / 0.993 / 2 * 60 / (2 * 3.14159265)
    assert rpm == pytest.approx(42.2, abs=0.1)
    assert physics_speed(0.2, PAPER) * 1500.0 == pytest.approx(rpm, rel=1e-6)


def test_dead_time_raises_it_and_flux_lowers_it() -> None:
    here = physics_speed(0.2, PAPER)
    assert physics_speed(0.2, replace(PAPER, dead_time=4e-6)) > here
    assert physics_speed(0.2, replace(PAPER, psi_f=2.0)) < here


def test_the_gap_surrounds_it() -> None:
    policy = make_policy("physics:0.2,10", PAPER)
    assert isinstance(policy, Hysteresis)
    assert policy.high / policy.low == pytest.approx(1.1 / 0.9)

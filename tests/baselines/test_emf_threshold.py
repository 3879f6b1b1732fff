"""The EMF switch compares volts with a share of the DC link."""

from collections.abc import Callable

import pytest

from sensorless.baselines.emf_threshold import emf_threshold
from sensorless.machine.motor import Motor
from sensorless.policy import Signals

PAPER = Motor.load("paper")
RATED_EMF = PAPER.omega_rated * PAPER.psi_f


def test_switches_at_32_and_22_volts_of_540(signals: Callable[..., Signals]) -> None:
    policy = emf_threshold("emf", 5.0, 1.0, PAPER)
    policy.reset(1)
    volts = [30.0, 32.0, 33.0, 30.0, 22.0, 21.0, 30.0]
    k_s = [float(policy.act(signals(emf=u / RATED_EMF))[0]) for u in volts]
    assert k_s == [1, 1, 0, 0, 0, 1, 1]


def test_speed_does_not_matter(signals: Callable[..., Signals]) -> None:
    policy = emf_threshold("emf", 5.0, 1.0, PAPER)
    policy.reset(1)
    assert policy.act(signals(speed=1.0)).tolist() == [1.0]


def test_the_gap_never_reaches_zero() -> None:
    policy = emf_threshold("emf", 2.0, 5.0, PAPER)
    assert policy.low * RATED_EMF == pytest.approx(0.002 * PAPER.u_dc)

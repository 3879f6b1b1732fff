"""Signal and noise of injection against the source paper's machine and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.machine.inverter import threshold_voltage
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.injection_signal import (
    injection_signal,
    suggested_injection,
)

PAPER = Motor.load("paper")


def test_the_papers_machine() -> None:
    """Derived before: 1.08 mA a degree, 4.5 degrees a step, 0.76 degrees at 5 mA and 20 Hz."""
    motor = replace(PAPER, i_rated=0.005 / 0.0012, adc_bits=32)
    s = injection_signal(motor, 20.0)
    assert s.slope[0] * math.pi / 180.0 == pytest.approx(1.08e-3, rel=0.01)
    assert s.noise_deg[0] == pytest.approx(0.76, rel=0.02)
    assert s.amplitude == pytest.approx(79.4e-3, rel=0.03)  # the largest along the line
    assert injection_signal(PAPER, 20.0).step_deg[0] == pytest.approx(4.5, rel=0.02)


def test_white_noise_through_the_loop() -> None:
    """The same figure from a loop that is run: demodulated second differences of white noise."""
    s = injection_signal(PAPER, 15.0)
    rng = np.random.default_rng(3)
    n, T_s, w = 200_000, PAPER.T_s, 2.0 * math.pi * 15.0
    sigma = math.hypot(0.0012 * PAPER.i_rated, 20.0 / 4096 / math.sqrt(12.0))
    x = rng.normal(0.0, sigma, n + 2)
    f = (x[2:] - 2.0 * x[1:-1] + x[:-2]) / 4.0 * (-1.0) ** np.arange(n) / s.slope[0]
    theta = omega = 0.0
    out = np.empty(n)
    for k in range(n):
        e = f[k] - theta
        omega += T_s * w * w * e
        theta += T_s * (omega + math.sqrt(2.0) * w * e)
        out[k] = theta
    assert np.rad2deg(out[5000:].std()) == pytest.approx(s.noise_deg[0], rel=0.1)


def test_suggestion_is_near_what_was_chosen_by_hand_and_scales() -> None:
    """The paper injects 50 V. Of twice the inductances, half the current takes twice the volts."""
    assert suggested_injection(PAPER, 15.0) == pytest.approx(50.0, rel=0.1)
    motor = Motor.load("ipmsm_2200w")
    twice = replace(
        motor,
        saturation=Saturation.linear(0.072, 0.102, motor.psi_f),
        i_rated=motor.i_rated,
        u_dc=5000.0,
        dead_time=0.0,
    )
    once = replace(motor, u_dc=5000.0, dead_time=0.0)
    assert suggested_injection(twice, 15.0) == pytest.approx(
        2.0 * suggested_injection(once, 15.0), rel=0.05
    )


def test_limits_of_the_suggestion() -> None:
    """Never beyond a fifth of the link; twice what dead time and switches take."""
    assert suggested_injection(replace(PAPER, u_dc=100.0), 15.0) == pytest.approx(20.0)
    assert suggested_injection(replace(PAPER, u_dc=88.0), 15.0) == pytest.approx(17.0)  # not 17.6
    late = replace(PAPER, dead_time=12e-6)
    assert late.dead_time_voltage == pytest.approx(32.4)
    assert suggested_injection(late, 15.0) == pytest.approx(67.0)  # 2 (32.4 + 0.875)
    measured = replace(late, u_transistor=2.0, u_diode=1.0)
    assert suggested_injection(measured, 15.0) == pytest.approx(68.0)  # 2 (32.4 + 1.5)
    assert threshold_voltage(replace(PAPER, u_dc=149.0)) == 0.0  # MOSFETs


def test_a_coarse_converter_asks_for_more_injection() -> None:
    """A step of 11 bits over +-12 A is 10 degrees of the answer across the axis."""
    motor = replace(Motor.load("ipmsm_2200w"), adc_bits=11)
    answer = 0.5 * motor.T_s * (1.0 / 0.036 - 1.0 / 0.051)  # [A/rad], of a volt
    volt = 2.0 * 12.0 / 2**11 / (answer * math.radians(10.0))
    assert suggested_injection(motor, 5.0) == pytest.approx(volt, rel=0.01)


def test_a_weak_saliency_asks_for_more_than_the_dead_time_takes() -> None:
    """1.3 / (1 - L_d/L_q) times, and at most a fifth of rated current: u T_s / (2 L_d)."""
    motor = replace(Motor.load("ipmsm_2200w"), dead_time=5e-6, adc_bits=16)
    taken = 540.0 * 5e-6 / 2e-4 + 0.875
    volt = 1.3 / (1.0 - 0.036 / 0.051) * taken
    assert suggested_injection(motor, 5.0) == pytest.approx(volt, rel=0.01)
    soft = replace(motor, saturation=Saturation.linear(0.0036, 0.0051, motor.psi_f))
    most = 0.2 * motor.i_rated * 2.0 * 0.0036 / motor.T_s
    assert 0.97 * most < suggested_injection(soft, 5.0) <= most

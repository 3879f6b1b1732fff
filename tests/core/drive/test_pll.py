"""The phase-locked loop: its recursion, its dynamics, its limits."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import Array, struct_dtype
from sensorless.observers.pll_design import pll_gains

Call = Callable[..., None]

T_S = 2e-4
PARAMS, STATE = struct_dtype("pll_params_t"), struct_dtype("pll_state_t")


def run(
    c: Call,
    theta: Array,
    hertz: float,
    slope: float = 1.0,
    omega_0: float = 0.0,
    omega_max: float = 1e4,
) -> tuple[Array, Array]:
    """Follow the angles ``theta``; returns angle errors and speeds before each update."""
    p, x = np.zeros(1, PARAMS), np.zeros(1, STATE)
    p["k_p"], p["k_i"] = pll_gains(hertz, slope)
    p["omega_max"], x["omega"] = omega_max, omega_0
    x["theta"] = math.remainder(theta[0], 2.0 * math.pi)
    errors, speeds = np.empty(len(theta)), np.empty(len(theta))
    for k, at in enumerate(theta):
        err = math.remainder(at - float(x["theta"][0]), 2.0 * math.pi)
        errors[k], speeds[k] = err, x["omega"][0]
        c("pll", p, x, slope * err, T_S)
    return errors, speeds


def test_recursion(c: Call) -> None:
    """omega first, then theta with the new omega, wrapped."""
    p, x = np.zeros(1, PARAMS), np.zeros(1, STATE)
    p["k_p"], p["k_i"], p["omega_max"] = 200.0, 2e4, 1e3
    x["theta"], x["omega"] = 3.1, 500.0
    c("pll", p, x, 0.25, T_S)
    omega = 500.0 + T_S * 2e4 * 0.25
    theta = math.remainder(3.1 + T_S * (omega + 200.0 * 0.25), 2.0 * math.pi)
    assert float(x["omega"][0]) == pytest.approx(omega, rel=1e-6)
    assert float(x["theta"][0]) == pytest.approx(theta, abs=1e-6)


@pytest.mark.parametrize("slope", [1.0, 0.78])
@pytest.mark.parametrize("hertz", [10.0, 20.0, 30.0])
def test_lag_under_acceleration(c: Call, hertz: float, slope: float) -> None:
    """An acceleration a is followed a / w_n^2 behind: 5.1 degrees at 20 Hz, 1400 rad/s^2."""
    t = T_S * np.arange(int(6.0 / hertz / T_S))
    errors, _ = run(c, 0.5 * 1400.0 * t**2, hertz, slope)
    lag = 1400.0 / (2.0 * math.pi * hertz) ** 2
    assert errors[-1] == pytest.approx(lag, rel=0.01)
    if hertz == 20.0:
        assert math.degrees(errors[-1]) == pytest.approx(5.1, abs=0.05)


@pytest.mark.parametrize("hertz", [10.0, 20.0, 50.0])
def test_step_response(c: Call, hertz: float) -> None:
    """A small step in angle decays like the designed second-order system."""
    t = T_S * np.arange(int(1.5 / hertz / T_S))
    theta = np.full(len(t), 0.1)
    theta[0] = 0.0
    errors, _ = run(c, theta, hertz)
    w = 2.0 * math.pi * hertz * math.sqrt(0.5)
    since = t - T_S
    want = 0.1 * np.exp(-w * since) * (np.cos(w * since) - np.sin(w * since))
    assert np.max(np.abs(errors[1:] - want[1:])) < 0.1 * 2.0 * math.pi * hertz * T_S


def test_constant_speed_is_followed_without_error(c: Call) -> None:
    """At 314 rad/s through many turns the angle error ends below 1e-4 rad."""
    theta = 314.0 * T_S * np.arange(4000)
    errors, speeds = run(c, theta, 20.0, omega_0=300.0)
    assert np.max(np.abs(errors[2000:])) < 1e-4
    assert np.max(np.abs(speeds[3000:] - 314.0)) < 0.1


def test_speed_is_bounded(c: Call) -> None:
    """The estimate never exceeds omega_max, in either direction."""
    for sign in (-1.0, 1.0):
        theta = sign * 900.0 * T_S * np.arange(2000)
        _, speeds = run(c, theta, 30.0, omega_max=600.0)
        assert np.max(np.abs(speeds)) <= 600.0
        assert abs(speeds[-1]) > 500.0

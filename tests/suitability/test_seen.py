"""What injection sees of a machine, how much each limit weighs, and the settings to choose."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from sensorless.machine.magnetics import mtpa
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.suitability.examine import examine
from sensorless.suitability.finding import LIMIT, NO, Finding

MOTOR = Motor.load("ipmsm_2200w")
PAPER = Motor.load("paper")
PLL_HZ = 15.0


def linear(**changes: Any) -> Motor:
    out = replace(MOTOR, **changes)
    return replace(out, saturation=Saturation.linear(out.L_d, out.L_q, out.psi_f))


def told(motor: Motor, words: str) -> list[Finding]:
    return [f for f in examine(motor, PLL_HZ).findings if words in f.text]


def noise_deg(motor: Motor) -> float:
    """RMS of the angle: sensor noise of 0.12 % of rated and rounding, through the loop."""
    step = motor.adc_range / 2.0 ** (motor.adc_bits - 1)
    sigma = math.hypot(0.0012 * motor.i_rated, step / math.sqrt(12.0))
    slope = 0.5 * motor.u_inj * motor.T_s * (1.0 / motor.L_d - 1.0 / motor.L_q)
    loop = math.sqrt(2.0 * 0.53 * 2.0 * math.pi * PLL_HZ * motor.T_s)
    return math.degrees(sigma * loop / slope)


@pytest.mark.parametrize(
    ("degrees", "weight"), [(2.8, None), (3.2, LIMIT), (9.5, LIMIT), (10.5, NO)]
)
def test_noise_of_the_angle_limits_from_3_degrees_and_refuses_from_10(
    degrees: float, weight: str | None
) -> None:
    """Injection of less voltage is as much noisier; the inverter's part is not in question."""
    quiet = linear(dead_time=0.0, u_transistor=1e-9)
    motor = replace(quiet, u_inj=quiet.u_inj * noise_deg(quiet) / degrees)
    found = told(motor, "angle noise of injection")
    assert [f.weight for f in found] == ([weight] if weight else [])


@pytest.mark.parametrize(("sharp", "weight"), [(5, LIMIT), (6, NO)])
def test_axes_that_turn_within_rated_current_limit_or_refuse(sharp: int, weight: str) -> None:
    """By 33 degrees, and by 43: no compensation is exact to a fraction of more than 40."""
    steep = replace(PAPER.saturation, a_qq=2.0, T=sharp)
    motor = replace(PAPER, saturation=steep, i_max=14.0, i_trip=60.0, adc_range=40.0)
    (found,) = told(motor, "turn by cross-coupling")
    assert found.weight == weight and "within rated current" in found.text
    turned = float(found.text.split("cross-coupling ")[1].split(" degrees")[0])
    assert turned > 40.0 if weight == NO else 25.0 < turned < 40.0


@pytest.mark.parametrize(("leans", "limited"), [(1.2, False), (1.4, True)])
def test_an_emf_that_leans_by_more_than_1_3_limits(leans: float, limited: bool) -> None:
    """L_q i_q over psi_f - (L_q - L_d) i_d, at the angle of most torque of rated current."""

    def weak(psi_f: float) -> Motor:
        return linear(psi_f=psi_f, L_q=2.0 * MOTOR.L_d)

    def lean_of(psi_f: float) -> float:
        motor = weak(psi_f)
        line = mtpa(motor).T
        at = [float(np.interp(motor.i_rated, np.hypot(*line), x)) for x in line]
        return motor.L_q * at[1] / (psi_f + (motor.L_d - motor.L_q) * at[0])

    motor = weak(brentq(lambda psi_f: lean_of(psi_f) - leans, 0.05, 0.5))
    found = told(motor, "times the flux of the EMF")
    assert [f.weight for f in found] == ([LIMIT] if limited else [])
    assert all(f"is {leans:.3g} times" in f.text for f in found)


@pytest.mark.parametrize(("share", "limited"), [(0.45, False), (0.55, True)])
def test_injected_current_of_half_the_rated_limits(share: float, limited: bool) -> None:
    """Its amplitude is u T_s / (2 L_d)."""
    L_d = MOTOR.u_inj * MOTOR.T_s / (2.0 * share * MOTOR.i_rated)
    found = told(linear(L_d=L_d, L_q=1.6 * L_d), "injected current")
    assert [f.weight for f in found] == ([LIMIT] if limited else [])
    assert all(f"is {share:.0%} of rated" in f.text for f in found)


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_the_suggested_converter_measures_what_control_may_reach(name: str) -> None:
    """The limit, with the suggested injection's current on top."""
    motor = Motor.load(name)
    e = examine(motor, PLL_HZ)
    assert e.suggested is not None and e.seen is not None
    ripple = e.seen.signal.amplitude * e.suggested["u_inj"] / motor.u_inj
    assert e.suggested["adc_range"] > 1.05 * (motor.i_max + ripple)


def test_a_period_is_suggested_that_leaves_twenty_to_a_turn() -> None:
    turn = 60.0 / (MOTOR.n_p * 3000.0)
    e = examine(linear(n_rated_rpm=3000.0, psi_f=0.3, T_s=turn / 12.0), PLL_HZ)
    assert e.suggested is not None
    assert turn / e.suggested["T_s"] == pytest.approx(20.0, rel=0.03)

"""What a machine reaches within its current and voltage, against closed forms and the paper."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor, Saturation
from sensorless.machine.rated_point import polar, rated_point, top_speeds

PAPER = Motor.load("paper")


def test_linear_machine_against_closed_forms() -> None:
    """MTPA of constant inductances, i_d = c - sqrt(c^2 + i_q^2), and the no-load speed."""
    motor = Motor.load("ipmsm_2200w")
    p = rated_point(motor)
    d = motor.L_q - motor.L_d
    i_d = motor.psi_f / (4 * d) - math.sqrt((motor.psi_f / (4 * d)) ** 2 + motor.i_rated**2 / 2)
    i_q = math.sqrt(motor.i_rated**2 - i_d**2)
    tau = 1.5 * motor.n_p * (motor.psi_f - d * i_d) * i_q
    assert p.torque == pytest.approx(tau, rel=1e-3)
    top = 0.97 * motor.u_dc / math.sqrt(3.0) / motor.psi_f / motor.n_p * 30.0 / math.pi
    assert p.top_speed == pytest.approx(top, rel=1e-9)


@pytest.mark.parametrize("i_rated", [0.97, 1.0, 1.3])
def test_the_least_current_of_all_of_rated_torque(i_rated: float) -> None:
    """Against MTPA of constant inductances, whatever rated current and the grid are."""
    motor = Motor.load("ipmsm_2200w")
    d, tau = motor.L_q - motor.L_d, motor.tau_rated

    def ampere(i: float) -> tuple[float, float]:
        i_d = motor.psi_f / (4 * d) - math.sqrt((motor.psi_f / (4 * d)) ** 2 + i**2 / 2)
        return i_d, math.sqrt(i**2 - i_d**2)

    def missing(i: float) -> float:
        i_d, i_q = ampere(i)
        return 1.5 * motor.n_p * (motor.psi_f - d * i_d) * i_q - tau

    least = float(brentq(missing, 0.1, motor.i_max))
    p = rated_point(replace(motor, i_rated=i_rated * motor.i_rated))
    assert p.current == pytest.approx(least, rel=1e-4)
    i_d, i_q = ampere(least)
    w = p.base_speed * motor.n_p * math.pi / 30.0
    u = math.hypot(
        motor.R_s * i_d - w * motor.L_q * i_q,
        motor.R_s * i_q + w * (motor.psi_f + motor.L_d * i_d),
    )
    assert u == pytest.approx(0.97 * motor.u_dc / math.sqrt(3.0), rel=1e-4)


def test_a_largest_current_just_short_of_rated_torque() -> None:
    """The row says so, and nothing is objected within the rounding of a name plate."""
    motor = Motor.load("ipmsm_2200w")
    least = rated_point(motor).current
    for share, objected in ((0.99, False), (0.97, True)):
        short = replace(motor, i_rated=share * least, i_max=share * least)
        p = rated_point(short)
        assert math.isinf(p.current) and (p.base_speed == 0.0) == objected
        assert (p.objection(short) is not None) == objected


def test_the_papers_machine() -> None:
    """Text on Table 1: the rated point needs field weakening from 540 V, and is then reached."""
    p = rated_point(PAPER)
    assert p.objection(PAPER) is None
    linear = replace(PAPER, saturation=Saturation.linear(0.063, 0.286, 0.993))
    assert rated_point(linear).base_speed == pytest.approx(1112 * 0.97, rel=0.02)


def test_beyond_the_voltage_is_named_with_what_is_reached() -> None:
    motor = replace(PAPER, u_dc=300.0)
    p = rated_point(motor)
    said = p.objection(motor)
    assert said is not None
    assert "14 N m at 1500 r/min is beyond 300 V" in said
    assert f"up to {p.speed:.0f} r/min" in said
    assert 300.0 < p.speed < 1000.0
    slower, faster = (replace(motor, n_rated_rpm=x * p.speed) for x in (1.0, 1.02))
    assert rated_point(slower).objection(slower) is None
    assert rated_point(faster).objection(faster) is not None


def test_beyond_the_current_is_named_with_what_is_needed() -> None:
    motor = replace(PAPER, i_rated=3.0)
    p = rated_point(motor)
    said = p.objection(motor) or ""
    assert f"needs {p.current:.3g} A" in said
    assert p.current == pytest.approx(4.2, abs=0.1)
    weak = replace(PAPER, i_rated=3.0, i_max=3.1)
    assert "more than i_max" in (rated_point(weak).objection(weak) or "")


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w"])
def test_the_torque_at_rated_speed_is_within_rated_current(name: str) -> None:
    """Peak current would give more than rated current does at any speed."""
    motor = Motor.load(name)
    p = rated_point(motor)
    assert motor.i_max > 1.2 * motor.i_rated
    assert p.torque_at_speed <= p.torque


def test_too_little_current_is_not_told_as_too_little_voltage() -> None:
    motor = Motor.load("ipmsm_2200w")
    weak = replace(motor, i_rated=0.8 * motor.i_rated)
    p = rated_point(weak)
    assert p.torque_at_speed == p.torque < motor.tau_rated
    said = p.objection(weak) or ""
    assert "but i_rated is" in said and "is beyond" not in said


def test_voltage_at_the_reported_speed_is_the_usable_one() -> None:
    """Back into the voltage equation, for the base speed."""
    i = polar(PAPER)
    psi = flux(PAPER.saturation, i)
    w = top_speeds(PAPER, i, psi)
    u = np.hypot(PAPER.R_s * i[:, 0] - w * psi[:, 1], PAPER.R_s * i[:, 1] + w * psi[:, 0])
    assert u == pytest.approx(np.full(len(u), 0.97 * 540.0 / math.sqrt(3.0)), rel=1e-9)


def test_too_little_current_does_not_hide_too_little_voltage() -> None:
    both = replace(PAPER, i_rated=0.6 * PAPER.i_rated, u_dc=0.5 * PAPER.u_dc)
    said = rated_point(both).objection(both) or ""
    assert "but i_rated is" in said and f"is beyond {both.u_dc:g} V" in said and "nowhere" in said


@pytest.mark.parametrize(("ratio", "odd"), [(1.48, False), (1.52, True)])
def test_a_torque_far_below_that_of_rated_current_is_odd(ratio: float, odd: bool) -> None:
    motor = Motor.load("ipmsm_2200w")
    weak = replace(motor, tau_rated=rated_point(motor).torque / ratio)
    said = rated_point(weak).spare(weak)
    assert (said is not None) == odd
    assert said is None or f"{ratio:.2g} times tau_rated" in said


@pytest.mark.parametrize(("ratio", "mixed"), [(1.19, False), (1.21, True)])
def test_a_mix_up_is_asked_for_where_it_is_likelier_than_rounding(
    ratio: float, mixed: bool
) -> None:
    motor = Motor.load("ipmsm_2200w")
    strong = replace(motor, tau_rated=ratio * rated_point(motor).torque)
    said = rated_point(strong).objection(strong) or ""
    assert "but i_rated is" in said and ("peak values?" in said) == mixed


def test_the_speed_of_rated_torque_is_told_up_to_rated() -> None:
    motor = replace(PAPER, u_dc=2.0 * PAPER.u_dc)
    assert rated_point(motor).speed == motor.n_rated_rpm


def test_no_flux_has_no_top_speed_and_a_drop_above_the_link_has_none_at_all() -> None:
    i = np.array([[1.0, 0.0], [0.0, 1.01 * 0.97 * 540.0 / math.sqrt(3.0) / PAPER.R_s]])
    found = top_speeds(PAPER, i, np.array([[0.0, 0.0], [1.0, 0.1]]))
    assert found.tolist() == [math.inf, 0.0]


def test_the_grid_has_the_currents_of_both_limits() -> None:
    size = np.unique(np.hypot(*polar(PAPER).T).round(9))
    assert size[-1] == pytest.approx(PAPER.i_max)
    assert np.abs(size - PAPER.i_rated).min() < 1e-9

"""The sliding-mode estimator in exact steady states, against closed forms."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor
from sensorless.observers.pll_design import pll_gains
from sensorless.observers.smo_design import design_smo
from tests.helpers.smo_steady import ESTIMATE, EXACT, STATE, Call, angles, linear, params

Angle = Callable[[DriveDesign, float, float, float], float]

PRINTED = replace(EXACT, cross="none", L_q_table=False, mtpa=False)
"""No cross-coupling compensation, data-sheet L_q, i_d = 0."""


def closed_form(motor: Motor, rpm: float, i: complex, L_q: float, dR: float, V: float) -> float:
    """Truth minus estimate [deg] with wrong L_q, R_s = model + dR, and a lost voltage V along i."""
    psi = flux(motor.saturation, np.array([[i.real, i.imag]]))[0]
    w, along = motor.rpm_to_electrical(rpm), V / abs(i)
    q = w * (psi[1] - L_q * i.imag) - (dR + along) * i.real
    d = w * (psi[0] - L_q * i.real) + (dR + along) * i.imag
    return -math.degrees(math.atan2(q, d))


@pytest.mark.parametrize(
    ("gain", "rpm", "lag"),
    [
        (315.0, 150.0, 1.6),
        (315.0, 300.0, 3.2),
        (315.0, 600.0, 6.5),
        (315.0, 1500.0, 15.8),
        (125.0, 300.0, 8.0),
    ],
)
def test_lag_of_the_sigmoid(c: Call, motor: Motor, gain: float, rpm: float, lag: float) -> None:
    """Without the cure the estimate lags by arg(g + R_s + j w L_q), -3.2 degrees at 300 r/min."""
    ideal = linear(motor)
    error, _ = angles(c, ideal, params(ideal, gain, cure=False), rpm, 1e-3 + 0j)
    want = math.degrees(math.atan2(motor.rpm_to_electrical(rpm) * motor.L_q, gain + motor.R_s))
    assert want == pytest.approx(lag, abs=0.3)
    assert np.mean(error) == pytest.approx(want, rel=0.05)


@pytest.mark.parametrize("i", [1e-3 + 0j, 2j, -0.6 + 1.8j, -2.0 + 3.0j, -0.5 - 0.8j])
@pytest.mark.parametrize(
    ("rpm", "left"), [(150.0, 0.2), (300.0, 0.2), (-300.0, 0.2), (600.0, 0.3), (1500.0, 0.7)]
)
def test_cure_removes_the_lag(c: Call, motor: Motor, rpm: float, left: float, i: complex) -> None:
    """With it less than 0.2 degrees remain at 300 r/min, with and without load."""
    ideal = linear(motor)
    mirrored = i if rpm > 0.0 else i.conjugate()
    error, _ = angles(c, ideal, params(ideal), rpm, mirrored)
    assert abs(np.mean(error)) < left
    assert np.ptp(error) < 0.05


POINTS = [
    # r/min, current [A], observer's L_q [H] (None: exact), R_s over observer's, lost voltage [V]
    (350.0, 2.07j, 0.286, 1.0, 0.0),
    (350.0, -0.618 + 1.844j, 0.286, 1.0, 0.0),
    (600.0, 4.7j, 0.286, 1.0, 0.0),
    (350.0, -2.0j, 0.286, 1.0, 0.0),
    (200.0, -0.618 + 1.844j, 0.286, 1.2, 6.9),
    (350.0, -0.618 + 1.844j, None, 1.2, 6.9),
    (100.0, -2.16 + 3.62j, None, 1.2, 6.9),
]


@pytest.mark.parametrize(("rpm", "i", "L_q", "R_ratio", "lost"), POINTS)
def test_parameter_errors(
    c: Call, motor: Motor, rpm: float, i: complex, L_q: float | None, R_ratio: float, lost: float
) -> None:
    """Wrong L_q, R_s and a dead-time voltage turn the estimate by the closed form."""
    psi = flux(motor.saturation, np.array([[i.real, i.imag]]))[0]
    used = float(psi[1]) / i.imag if L_q is None else L_q
    p = params(motor, R_s=motor.R_s / R_ratio)
    error, _ = angles(c, motor, p, rpm, i, used, lost)
    want = closed_form(motor, rpm, i, used, motor.R_s * (1.0 - 1.0 / R_ratio), lost)
    assert np.mean(error) == pytest.approx(want, abs=0.25)


@pytest.mark.parametrize(("rpm", "tau", "error"), [(350.0, 6.0, 7.39), (600.0, 6.0, 7.39)])
def test_constant_inductance_in_the_closed_loop(
    steady_angle: Angle, rpm: float, tau: float, error: float
) -> None:
    """With the data-sheet L_q and i_d = 0 the drive settles 7.39 degrees off at 6 N m."""
    assert steady_angle(PRINTED, 0.0, rpm, tau) == pytest.approx(error, abs=0.25)


@pytest.mark.parametrize("tau", [-6.0, 0.0, 6.0, 14.0])
def test_inductance_table_in_the_closed_loop(steady_angle: Angle, tau: float) -> None:
    """With L_q over the torque current less than 0.4 degrees remain."""
    assert abs(steady_angle(EXACT, 0.0, 600.0, tau)) < 0.4


def test_half_blend_of_the_printed_scheme(steady_angle: Angle) -> None:
    """Both raw errors nearly cancel at k_s = 0.5; compensating one of them makes it worse."""
    assert steady_angle(PRINTED, 0.5, 350.0, 6.0) == pytest.approx(-1.05, abs=0.2)
    one_sided = replace(PRINTED, cross="table")
    assert steady_angle(one_sided, 0.5, 350.0, 6.0) == pytest.approx(3.31, abs=0.3)


@pytest.mark.parametrize(
    ("hertz", "i_q", "stable"),
    [(30.0, -1.9, True), (30.0, -2.9, False), (20.0, -2.9, True), (20.0, -4.4, False)],
)
def test_regenerating_bound(c: Call, motor: Motor, hertz: float, i_q: float, stable: bool) -> None:
    """Damped while i_q > -(2 zeta / w_n) E / (L_q - L_d): -2.45 A at 30 Hz, 350 r/min."""
    ideal = linear(motor)
    p = params(ideal)
    p["pll"]["k_p"], p["pll"]["k_i"] = pll_gains(hertz, 1.0)
    error, _ = angles(c, ideal, p, 350.0, 1j * i_q)
    assert (np.ptp(error) < 0.1) == stable


@pytest.mark.parametrize("ratio", [0.1, 0.4, 1.0, 1.9])
def test_stable_over_the_gain_range(c: Call, motor: Motor, ratio: float) -> None:
    """The forward-Euler step holds from a tenth to nearly twice the deadbeat gain."""
    ideal = linear(motor)
    error, _ = angles(c, ideal, params(ideal, ratio * motor.L_d / motor.T_s), 600.0, 2j)
    assert np.max(np.abs(error)) < 0.5


def test_gain_beyond_the_range_is_refused(motor: Motor) -> None:
    """At twice the deadbeat gain the observer would oscillate."""
    with pytest.raises(UserError, match=r"smo_gain: 630 V/A; give more than 0 and less than"):
        design_smo(
            motor,
            pll_hz=30.0,
            gain=630.0,
            k=400.0,
            cross_hz=math.inf,
            emf_hz=math.inf,
            floor_rpm=40.0,
            switching="sigmoid",
            lag_cure=True,
            motoring=1.0,
            omega_max=800.0,
        )


def test_below_its_floor_the_estimator_follows(c: Call, motor: Motor) -> None:
    """At rest there is no EMF: angle and speed are the ones it is told."""
    p, x, y = params(motor), np.zeros(1, dtype=STATE), np.zeros(1, dtype=ESTIMATE)
    i, u = np.array([0.5, 0.1], np.float32), np.array([1.0, 2.0], np.float32)
    for _ in range(20):
        c("smo_observe", p, x, y, i, u, motor.L_q, 3.0, 0.9, motor.T_s)
    assert y["valid"][0] == 0.0
    assert y["err"][0] == 0.0
    assert y["pll"]["theta"][0] == pytest.approx(0.9 + 3.0 * motor.T_s, abs=1e-6)
    assert y["pll"]["omega"][0] == 3.0

"""The sliding-mode estimator in exact steady states, against closed forms."""

import cmath
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import Array, struct_dtype
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign, control_record
from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.pll_design import pll_gains
from sensorless.plant.case import PlantCase
from sensorless.plant.run import plant_arrays

Call = Callable[..., None]
Angle = Callable[[DriveDesign, float, float, float], float]

STATE = struct_dtype("smo_state_t")
ESTIMATE = struct_dtype("emf_estimate_t")

EXACT = DriveDesign(
    smo_pll_hz=20.0,
    smo_cross_hz=math.inf,
    smo_emf_hz=math.inf,
    smo_gain=1.0,
    L_q_bias=1.0,
    speed_hz=1.0,
)
PRINTED = replace(EXACT, cross="none", L_q_table=False, mtpa=False)
"""No cross-coupling compensation, data-sheet L_q, i_d = 0."""


def linear(motor: Motor) -> Motor:
    return replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))


def holding_voltage(motor: Motor, rpm: float, i: complex) -> complex:
    """Voltage, held in the stator frame from angle 0 on, that brings the flux of ``i`` back [V]."""
    omega = motor.rpm_to_electrical(rpm)
    case = PlantCase(
        T_s=motor.T_s,
        n_p=motor.n_p,
        R_s=motor.R_s,
        saturation=motor.saturation,
        J=math.inf,
        B=0.0,
        i_d=i.real,
        i_q=i.imag,
        theta_m=0.0,
        w_M=omega / motor.n_p,
    )

    def moved(u: Floats) -> Floats:
        plant, state = plant_arrays(case, 16)
        rows = plant_run(plant, state, np.array([[u[0], u[1], 0.0]]))
        return np.asarray(rows[1, 2:4] - rows[0, 2:4])

    u = np.zeros(2)
    for _ in range(6):
        here = moved(u)
        slope = np.stack([moved(u + step) - here for step in np.eye(2)], axis=-1)
        u = u - np.linalg.solve(slope, here)
    assert np.max(np.abs(moved(u))) < 1e-12
    return complex(u[0], u[1])


def params(
    motor: Motor,
    gain: float = 315.0,
    *,
    cure: bool = True,
    k: float = 1e4,
    R_s: float | None = None,
) -> Array:
    """A record of ``smo_params_t`` with gain ``gain`` [V/A] at the origin."""
    p = np.array(control_record(motor, EXACT)["smo"]).reshape(1)
    p["k"], p["half_a"], p["lag_cure"] = k, gain / k, float(cure)
    p["R_s"] = motor.R_s if R_s is None else R_s
    return p


def angles(
    c: Call,
    motor: Motor,
    p: Array,
    rpm: float,
    i: complex,
    L_q: float | None = None,
    u_lost: float = 0.0,
    periods: int = 2500,
) -> tuple[Floats, Floats]:
    """Truth minus estimate [deg] and model-current error [A] in a steady state of ``i`` [A].

    u_lost: voltage that the drive commands along the current and the inverter loses [V].
    """
    omega = motor.rpm_to_electrical(rpm)
    u = holding_voltage(motor, rpm, i)
    u += u_lost * i / abs(i) * cmath.exp(0.5j * omega * motor.T_s) if u_lost else 0.0
    x, y = np.zeros(1, dtype=STATE), np.zeros(1, dtype=ESTIMATE)
    y["pll"]["omega"], x["omega_f"], y["pll"]["theta"] = omega, omega, 0.1
    out, miss = np.empty(periods), np.empty(periods)
    for k in range(periods):
        theta = math.remainder(omega * motor.T_s * k, 2.0 * math.pi)
        now = i * cmath.exp(1j * theta)
        was = u * cmath.exp(1j * (theta - omega * motor.T_s))
        out[k] = math.degrees(math.remainder(theta - float(y["pll"]["theta"][0]), 2.0 * math.pi))
        c(
            "smo_observe",
            p,
            x,
            y,
            np.array([now.real, now.imag], np.float32),
            np.array([was.real, was.imag], np.float32),
            motor.L_q if L_q is None else L_q,
            omega,
            0.0,
            motor.T_s,
        )
        miss[k] = x["i_hat"]["a"][0] - now.real
    return out[-500:], miss[-500:]


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


def test_sign_chatters_and_sigmoid_does_not(c: Call, motor: Motor) -> None:
    """Signum: the model current jumps by up to 2 T_s (k + E) / L_d; sigmoid: it stays still."""
    ideal = linear(motor)
    p = params(ideal, k=400.0)
    smooth, small = angles(c, ideal, p, 300.0, 1e-3 + 0j)
    p["use_sign"] = 1.0
    rough, big = angles(c, ideal, p, 300.0, 1e-3 + 0j)
    emf = motor.rpm_to_electrical(300.0) * motor.psi_f
    assert np.ptp(big) > 1.0
    assert np.ptp(big) <= 2.1 * motor.T_s / motor.L_d * (400.0 + emf)
    assert np.ptp(small) < 0.5
    assert np.ptp(rough) > 20.0 * np.ptp(smooth)


@pytest.mark.parametrize("ratio", [0.1, 0.4, 1.0, 1.9])
def test_stable_over_the_gain_range(c: Call, motor: Motor, ratio: float) -> None:
    """The forward-Euler step holds from a tenth to nearly twice the deadbeat gain."""
    ideal = linear(motor)
    error, _ = angles(c, ideal, params(ideal, ratio * motor.L_d / motor.T_s), 600.0, 2j)
    assert np.max(np.abs(error)) < 0.5


def test_gain_beyond_the_range_is_refused(motor: Motor) -> None:
    """At twice the deadbeat gain the observer would oscillate."""
    from sensorless.observers.smo_design import design_smo

    with pytest.raises(UserError, match=r"smo_gain: 630 V/A; give more than 0 and less than"):
        design_smo(
            motor,
            pll_hz=30.0,
            gain=630.0,
            k=400.0,
            cross_hz=math.inf,
            emf_hz=math.inf,
            floor_rpm=40.0,
            sign=False,
            lag_cure=True,
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

"""The injection estimator on an ideal machine, against exact closed forms."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from sensorless.core.api import TRACE_NAMES, sim_trace
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.magnetics import cross_angle, flux, inverse_inductance
from sensorless.machine.motor import Motor
from sensorless.observers.tracking import rated_acceleration
from tests.helpers.injection_bench import DESIGN, STATE, Bench, Call, error_signal

Angle = Callable[[DriveDesign, float, float, float], float]

L_D, L_Q = 0.063, 0.286


@pytest.mark.parametrize("rpm", [0.0, 150.0])
def test_amplitude(c: Call, motor: Motor, rpm: float) -> None:
    """u_inj T_s / 2 L_d = 79.37 mA at lock within 0.1 %."""
    _, amplitude, _ = Bench(c, motor, rpm, 0.0, closed=False).run(60, 20)
    assert amplitude == pytest.approx(79.37e-3, rel=1e-3)


def test_slope(c: Call, motor: Motor) -> None:
    """1 - L_d / L_q = 0.780 per radian at lock, positive when the rotor leads."""
    plus, minus = (Bench(c, motor, 0.0, e, closed=False).run(60, 20)[0] for e in (0.02, -0.02))
    assert (plus - minus) / 0.04 == pytest.approx(0.780, abs=0.001)


@pytest.mark.parametrize("i", [2.065j, -0.618 + 1.844j, -2.065j])
def test_slope_under_load(c: Call, motor: Motor, i: complex) -> None:
    """At 6 N m: 0.68 around the rotor axis, and 1 - L_min / L_max, 0.70, where it locks.

    That is at theta_cross, on the turned magnetic axes; 1 - L_d / L_q alone would be 0.685.
    """
    at = np.array([[i.real, i.imag]])

    def slope(e: float) -> float:
        low, high = (
            Bench(c, motor, 0.0, e + d, closed=False, current=i).run(60, 20)[0]
            for d in (-0.02, 0.02)
        )
        return (high - low) / 0.04

    lock = float(cross_angle(motor, at)[0])
    axes = np.linalg.eigvalsh(inverse_inductance(motor.saturation, flux(motor.saturation, at))[0])
    zero, _, _ = Bench(c, motor, 0.0, lock, closed=False, current=i).run(60, 20)
    assert zero == pytest.approx(0.0, abs=0.002)
    assert slope(lock) == pytest.approx(1.0 - axes[0] / axes[1], abs=0.002)
    assert slope(0.0) == pytest.approx(0.68, abs=0.02)


@pytest.mark.parametrize("degrees", [-60.0, -30.0, 15.0, 30.0, 45.0, 60.0, 70.0])
def test_error_signal_far_from_lock(c: Call, motor: Motor, degrees: float) -> None:
    """The curve of the exact relation, not the sine of the source paper."""
    e = math.radians(degrees)
    got, _, _ = Bench(c, motor, 0.0, e, closed=False).run(60, 20)
    assert got == pytest.approx(error_signal(motor, e), abs=2e-3)


@pytest.mark.parametrize("share", [0.5, -1.0, 2.0, -3.0])
@pytest.mark.parametrize("rises", [True, False])
def test_lag_of_an_acceleration(c: Call, motor: Motor, share: float, rises: bool) -> None:
    """The loop of this acceleration over bandwidth squared, and less lag where that has risen.

    At rest in its frame the loop needs k_i f^2 err = d omega / dt. The bandwidth factor f is 1
    where rated torque on the own inertia leaves three quarters of its lag, 2 at one and a half.
    """
    design = DriveDesign(estimator="smo")
    bench = Bench(c, motor, 0.0, 0.0, closed=True, design=design)
    bench.p["rise_max"] *= rises
    bench.acceleration = share * rated_acceleration(motor)
    lag = rated_acceleration(motor) / (2.0 * math.pi * derive(motor, design).hfi_pll_hz) ** 2
    slope = 1.0 - motor.L_d / motor.L_q
    low, high = (error_signal(motor, x * lag) for x in (0.75, 1.5))

    def left(e: float) -> float:
        err = error_signal(motor, e)
        f = 1.0 + rises * min(max((err - low) / (high - low), 0.0), 1.0)
        return abs(share) * lag - f * f * err / slope

    expected = math.degrees(brentq(left, 0.0, math.pi / 4.0))
    _, _, angle = bench.run(600, 1)
    assert angle == pytest.approx(math.copysign(expected, share), rel=0.03)


@pytest.mark.parametrize("rpm", [-600.0, -150.0, 0.0, 150.0, 350.0, 600.0, 1500.0])
def test_lock_has_no_offset(c: Call, motor: Motor, rpm: float) -> None:
    """Injection at mid-interval and per-sample angles leave less than 0.02 degrees at any speed."""
    _, _, angle = Bench(c, motor, rpm, 0.2, closed=True).run(1500, 200)
    assert abs(angle) < 0.02


@pytest.mark.parametrize(
    ("scheme", "delay_cure", "shift"),
    [
        ("rotating", True, 0.0),
        ("rotating", False, 1.5 * L_D / (L_Q - L_D)),
        ("stationary", True, 0.5 * L_Q / (L_Q - L_D)),
        ("stationary", False, (0.5 * L_Q + 1.5 * L_D) / (L_Q - L_D)),
    ],
)
@pytest.mark.parametrize("rpm", [150.0, 350.0, 600.0, 1500.0])
def test_lock_offset_of_the_schemes(
    c: Call, motor: Motor, rpm: float, scheme: str, delay_cure: bool, shift: float
) -> None:
    """Late axes turn the lock by (L_q e_d - L_d e_v) / (L_q - L_d), of w T_s each.

    Demodulation as published looks half a period ahead of the interval it measures (e_d), and an
    injection without compensation acts 1.5 periods late (e_v): 0, 0.42, 0.64 and 1.07 w T_s.
    """
    design = replace(DESIGN, hfi_scheme=scheme, hfi_delay_cure=delay_cure)
    _, _, angle = Bench(c, motor, rpm, 0.1, closed=True, design=design).run(1500, 200)
    step = math.degrees(motor.rpm_to_electrical(rpm) * motor.T_s)
    assert angle == pytest.approx(shift * step, abs=0.05)


def test_unnormalised_error(c: Call, motor: Motor) -> None:
    """Without the division (Eq. 15): the same loop at no load, but its gain follows the voltage."""
    design = replace(DESIGN, hfi_normalised=False)
    bench = Bench(c, motor, 150.0, 0.2, closed=True, design=design)
    assert abs(bench.run(1500, 200)[2]) < 0.02
    bench = Bench(c, motor, 0.0, 0.02, closed=False, design=design)
    full, _, _ = bench.run(60, 20)
    bench.p["u_inj"] *= 0.5
    half, _, _ = bench.run(60, 20)
    assert half == pytest.approx(0.5 * full, rel=0.01)
    plain = Bench(c, motor, 0.0, 0.02, closed=False)
    assert full > 0.0 and plain.run(60, 20)[0] == pytest.approx(10.0 * full, rel=0.01)


@pytest.mark.parametrize("start", [20.0, -50.0])
def test_wrong_demodulation_sign_locks_across(c: Call, motor: Motor, start: float) -> None:
    """With the sign of another period's voltage the loop settles 90 degrees off."""
    bench = Bench(c, motor, 100.0, math.radians(start), closed=True, sign=-1.0)
    _, _, angle = bench.run(1500, 200)
    assert abs(angle) == pytest.approx(90.0, abs=1.0)


@pytest.mark.parametrize("start", [150.0, -120.0])
def test_polarity_is_not_seen(c: Call, motor: Motor, start: float) -> None:
    """Beyond 90 degrees the loop takes the other magnet pole: the initial angle has to be known."""
    _, _, angle = Bench(c, motor, 100.0, math.radians(start), closed=True).run(1500, 200)
    assert abs(angle) == pytest.approx(180.0, abs=0.1)


def test_without_injection_the_estimator_follows(c: Call, motor: Motor) -> None:
    """Until two alternating voltages have acted the angle is the one it is told, and valid is 0."""
    p = np.array(control_record(motor, DESIGN)["hfi"]).reshape(1)
    x = np.zeros(1, dtype=STATE)
    valid = []
    for k in range(8):
        c("hfi_observe", p, x, 0.1, -0.2, 0.7, 30.0, motor.T_s)
        valid.append(float(x["valid"][0]))
        if not valid[-1]:
            assert x["pll"]["theta"][0] == pytest.approx(0.7 + 30.0 * motor.T_s, abs=1e-6)
            assert x["pll"]["omega"][0] == 30.0
        sign = np.empty(1, dtype=np.float32)
        c("hfi_inject", p, x, int(k >= 2), sign)
    assert valid == [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]


def test_injection_holds_and_stops(c: Call, motor: Motor) -> None:
    """Signs alternate while wanted and for n_hold periods after, then stay 0."""
    p = np.array(control_record(motor, replace(DESIGN, injection_hold=0.002))["hfi"]).reshape(1)
    x = np.zeros(1, dtype=STATE)
    signs: list[float] = []
    for k in range(30):
        out = np.empty(1, dtype=np.float32)
        c("hfi_inject", p, x, int(k < 6), out)
        signs.append(float(out[0]))
    assert p["n_hold"][0] == 10.0
    on = [s for s in signs if s]
    assert len(on) == 6 + 9
    assert signs[len(on) :] == [0.0] * (30 - len(on))
    assert all(a == -b for a, b in pairwise(on))


@pytest.mark.parametrize("rpm", [-800.0, 0.0, 350.0, 800.0])
def test_drive_injects_at_mid_interval(steady_angle: Angle, rpm: float) -> None:
    """In the whole drive no offset is left either; half a period more would cost 0.27 degrees."""
    assert abs(steady_angle(DESIGN, 1.0, rpm, 0.0)) < 0.05


PRINTED = replace(DESIGN, cross="none", mtpa=False)


@pytest.mark.parametrize(
    ("rpm", "tau", "error"),
    [(150.0, 6.0, -7.70), (150.0, -6.0, 7.70), (-150.0, -6.0, 7.70), (150.0, 14.0, -14.1)],
)
def test_cross_coupling_turns_the_lock(
    steady_angle: Angle, rpm: float, tau: float, error: float
) -> None:
    """Uncompensated, the closed loop settles at the tabulated angle; its sign is that of -i_q."""
    assert steady_angle(PRINTED, 1.0, rpm, tau) == pytest.approx(error, abs=0.15)


@pytest.mark.parametrize("tau", [-6.0, 3.0, 6.0, 14.0])
def test_table_compensates_cross_coupling(steady_angle: Angle, tau: float) -> None:
    """With the compensation curve less than 0.2 degrees remain."""
    design = replace(PRINTED, cross="table")
    assert abs(steady_angle(design, 1.0, 150.0, tau)) < 0.2


def test_a_frame_that_jumps_is_no_error(c: Call, motor: Motor) -> None:
    """A current I along d, 50 times the answer X, whose angle is corrected by phi every period.

    Told of the corrections, the estimator finds its angle error. Otherwise the second difference
    of the frame's angle comes to it, times I / (4 X), with the sign of the injection.
    """
    p = np.array(control_record(motor, DESIGN)["hfi"]).reshape(1)
    p["pll"]["k_p"] = p["pll"]["k_i"] = 0.0
    answer, size = 0.5 * motor.T_s * motor.u_inj / motor.L_d, 50.0
    jumps = np.random.default_rng(4).normal(0.0, 1e-3, 400)
    at = np.cumsum(jumps)
    signs = np.resize([1.0, -1.0], len(at))
    for told in (1.0, 0.0):
        x = np.zeros(1, dtype=STATE)
        found = np.zeros(len(at))
        for k, (angle, sign) in enumerate(zip(at, signs, strict=True)):
            i = (size + sign) * answer
            x["pll"]["theta"], x["jump"] = angle, told * jumps[k]
            x["sign_2"], x["sign_3"] = sign, -sign
            c("hfi_observe", p, x, i, 0.0, angle, 0.0, motor.T_s)
            found[k] = x["err"][0]
        bend = signs[2:] * 0.25 * size * np.diff(at, 2)
        expected = -at[2:] - (1.0 - told) * bend
        assert found[2:] == pytest.approx(expected, abs=0.003)
        assert np.std(bend) > 0.01, "of what is not told"


def swing(motor: Motor, load: float) -> float:
    """Share of the angle error's power at a quarter of the PWM frequency, at rest under a load."""
    s = Scenarios.nominal(motor, np.array([1], dtype=np.uint64), 0.6)
    s.tau[:], s.noise[:] = load * motor.tau_rated, 0.0
    rows = sim_trace(SimFactory(motor, DriveDesign()).build(s), round(0.5 / motor.T_s), 1.0)[-400:]
    x = rows[:, TRACE_NAMES.index("theta_e_err")]
    spectrum = np.abs(np.fft.rfft(x - x.mean()))
    return float(spectrum[100] ** 2 / np.sum(spectrum**2))


def test_the_frame_does_not_feed_on_itself() -> None:
    """A correction by K e, d current I, answer X: K I / (4 X) is 1.1, beyond the bound 0.71."""
    assert swing(Motor.load("brusa_hsm1"), 1.2) < 0.1

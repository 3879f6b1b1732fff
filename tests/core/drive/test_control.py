"""Speed and current control: limits, anti-windup, reference tracking, turn of the voltage."""

import cmath
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import Array, struct_dtype
from sensorless.design.control import operating_line
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

Call = Callable[..., None]

STATE = struct_dtype("control_state_t")
U_DC = 540.0
RESERVE = 50.0
AMPLE = 1e5
"""A DC link [V] that no reference exhausts: what the speed control does on its own."""


DESIGN = DriveDesign(speed_hz=2.5, speed_weight=0.0, current_hz=120.0, i_q_slew=150.0)


def rest() -> Array:
    """Nothing yet; the torque current does not give way."""
    x = np.zeros(1, dtype=STATE)
    x["i_d_end"] = -np.inf
    return x


def params(motor: Motor, **changes: Any) -> Array:
    return np.array(control_record(motor, replace(DESIGN, **changes))["control"]).reshape(1)


def step(
    c: Call,
    motor: Motor,
    p: Array,
    x: Array,
    i: complex,
    *,
    theta: float = 0.0,
    omega: float = 0.0,
    omega_ref: float = 0.0,
    u_dc: float = U_DC,
    reserve: float = RESERVE,
) -> complex:
    """One period; ``i`` in the stator frame [A]. Returns the voltage in the stator frame [V]."""
    u = np.empty(2, dtype=np.float32)
    c(
        "control",
        p,
        x,
        np.array([theta, omega], np.float32),
        np.array([i.real, i.imag], np.float32),
        u_dc,
        omega_ref,
        reserve,
        motor.T_s,
        u,
    )
    return complex(u[0], u[1])


@pytest.mark.parametrize("reserve", [0.0, 50.0, 150.0])
def test_voltage_circle_with_reserve(c: Call, motor: Motor, reserve: float) -> None:
    """No state and no reference asks for more than u_dc / sqrt(3) less the reserve."""
    rng = np.random.default_rng(1)
    p = params(motor)
    longest = 0.0
    for _ in range(400):
        x = rest()
        x["u_int"]["d"], x["u_int"]["q"] = rng.normal(0.0, 150.0, 2)
        x["i_ref"]["q"] = rng.normal(0.0, 5.0)
        i = complex(*rng.normal(0.0, 5.0, 2))
        u = step(
            c,
            motor,
            p,
            x,
            i,
            theta=rng.uniform(-3.0, 3.0),
            omega=rng.normal(0.0, 200.0),
            omega_ref=rng.normal(0.0, 300.0),
            reserve=reserve,
        )
        longest = max(longest, abs(u))
    limit = U_DC / math.sqrt(3.0) - reserve
    assert limit * 0.999 < longest <= limit * (1.0 + 1e-5)


def test_limited_voltage_keeps_its_direction(c: Call, motor: Motor) -> None:
    """The limit shortens the vector and does not turn it."""
    p = params(motor)
    free, tight = (rest() for _ in range(2))
    for x in (free, tight):
        x["u_int"]["d"], x["u_int"]["q"] = 30.0, 40.0
    u = step(c, motor, p, free, 0j, reserve=0.0)
    v = step(c, motor, p, tight, 0j, reserve=290.0)
    assert abs(u) == pytest.approx(50.0, rel=0.2)
    assert abs(v) == pytest.approx(U_DC / math.sqrt(3.0) - 290.0, rel=1e-3)
    assert cmath.phase(u / v) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("omega", [-400.0, 0.0, 150.0])
def test_voltage_is_turned_to_the_middle_of_its_hold(c: Call, motor: Motor, omega: float) -> None:
    """theta + 1.5 omega T_s: one period of computation and half of the hold."""
    p, x = params(motor), rest()
    p["k_fw"] = 0.0
    x["u_int"]["d"] = 20.0
    x["i_int"] = p["k_p_speed"] * (1.0 - p["weight_ref"]) * omega
    u = step(c, motor, p, x, 0j, theta=0.7, omega=omega, omega_ref=omega)
    in_rotor_frame = complex(20.0, omega * motor.psi_f)
    assert abs(u) == pytest.approx(
        min(abs(in_rotor_frame), U_DC / math.sqrt(3.0) - RESERVE), rel=1e-3
    )
    turn = cmath.phase(u / in_rotor_frame)
    assert turn == pytest.approx(0.7 + 1.5 * omega * motor.T_s, abs=1e-3)


class Bench:
    """Current control at held speed on an ideal machine with the design's own inductances."""

    def __init__(self, c: Call, motor: Motor, p: Array, omega: float) -> None:
        self.c, self.motor, self.p, self.omega = c, motor, p, omega
        self.x = rest()
        self.L = (float(p["L_d"][0]), float(p["L_q"][0]))
        self.i, self.theta, self.wait = 0j, 0.0, 0j

    def run(self, i_q_ref: float, periods: int, u_dc: float = U_DC) -> Floats:
        """Torque current [A] of every period; the reference is forced past the speed control."""
        rows = np.empty(periods)
        T_s, n = self.motor.T_s, 20
        self.p["k_p_speed"], self.p["k_i_speed"] = 1e-9, 0.0
        for k in range(periods):
            rows[k] = self.i.imag
            self.x["i_int"] = i_q_ref
            u_next = step(
                self.c,
                self.motor,
                self.p,
                self.x,
                self.i * cmath.exp(1j * self.theta),
                theta=math.remainder(self.theta, 2.0 * math.pi),
                omega=self.omega,
                u_dc=u_dc,
            )
            for _ in range(n):
                self.theta += self.omega * T_s / n
                v = self.wait * cmath.exp(-1j * self.theta) - self.motor.R_s * self.i
                L_d, L_q = self.L
                psi = complex(L_d * self.i.real + self.motor.psi_f, L_q * self.i.imag)
                v -= 1j * self.omega * psi
                self.i += complex(v.real / L_d, v.imag / L_q) * T_s / n
            self.wait = u_next
        return rows


@pytest.mark.parametrize("omega", [0.0, 150.0, -150.0])
def test_current_control(c: Call, motor: Motor, omega: float) -> None:
    """A step arrives without lasting error; delays make it faster than designed."""
    p = params(motor, i_q_slew=1e6, mtpa=False)
    bench = Bench(c, motor, p, omega)
    bench.run(0.0, 300)
    i_q = bench.run(1.0, 300)
    assert i_q[-50:] == pytest.approx(1.0, abs=0.01)
    rise = (int(np.argmax(i_q > 0.9)) - int(np.argmax(i_q > 0.1))) * motor.T_s
    designed = math.log(9.0) / (2.0 * math.pi * 120.0)
    assert 0.4 * designed < rise < 1.2 * designed
    assert np.max(i_q) < 1.12


def test_current_control_does_not_wind_up(c: Call, motor: Motor) -> None:
    """At the voltage limit the integrators come to rest, and the return from it is short."""
    p = params(motor, i_q_slew=1e6, mtpa=False)
    p["k_fw"] = 0.0
    bench = Bench(c, motor, p, 100.0)
    bench.run(0.0, 300)
    starved = bench.run(5.0, 2500, u_dc=150.0)
    assert starved[-1] < 2.0, "the voltage was not short"
    before = [float(bench.x["u_int"][a][0]) for a in "dq"]
    bench.run(5.0, 1000, u_dc=150.0)
    assert [float(bench.x["u_int"][a][0]) for a in "dq"] == pytest.approx(before, abs=2.0)
    back = bench.run(0.5, 250)
    assert np.max(np.abs(back[100:] - 0.5)) < 0.05


def test_field_weakening_holds_the_voltage(c: Call, motor: Motor) -> None:
    """Above base speed i_d brings the voltage to its margin; below it i_d is back at zero."""
    p = params(motor, mtpa=False)
    bench = Bench(c, motor, p, 300.0)
    bench.run(0.0, 4000)
    u_max = U_DC / math.sqrt(3.0) - RESERVE
    margin = float(p["fw_margin"][0])
    assert float(bench.x["u_abs"][0]) == pytest.approx(margin * u_max, rel=0.01)
    want = (margin * u_max / 300.0 - motor.psi_f) / motor.L_d
    assert bench.i.real == pytest.approx(want, abs=0.1)
    bench.omega = 150.0
    bench.run(0.0, 4000)
    assert bench.i.real == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_reference_limits(c: Call, motor: Motor, sign: float) -> None:
    """The torque current rises by its slew and stays within the current limit with i_d."""
    p, x = params(motor), rest()
    p["k_fw"] = 0.0
    last = 0.0
    for k in range(400):
        step(c, motor, p, x, 0j, omega_ref=sign * 400.0, u_dc=AMPLE)
        i_d, i_q = float(x["i_ref"]["d"][0]), float(x["i_ref"]["q"][0])
        assert abs(i_q) - abs(last) <= 150.0 * motor.T_s * (1.0 + 1e-3)
        assert math.hypot(i_d, i_q) <= motor.i_max * 1.02
        last = i_q
        if k == 99:
            assert sign * i_q == pytest.approx(150.0 * motor.T_s * 100, rel=0.02)
    nodes = operating_line(motor, use_mtpa=True)
    want = float(np.interp(abs(last), nodes[:, 1], nodes[:, 0]))
    assert i_d == pytest.approx(want, abs=0.01)
    assert last * sign > 0.7 * motor.i_max


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_torque_current_waits_for_voltage(c: Call, motor: Motor, sign: float) -> None:
    """Short of voltage |i_q| does not rise and the speed integrator rests; it may still fall."""
    p, x = params(motor), rest()
    p["k_fw"] = 0.0
    x["i_ref"]["q"] = x["i_int"] = 2.0 * sign
    x["u_abs"], x["u_max"] = 200.0, 199.0
    for _ in range(3000):
        step(c, motor, p, x, 0j, omega_ref=sign * 100.0, u_dc=60.0, reserve=0.0)
        assert abs(float(x["i_ref"]["q"][0])) <= 2.0
    before = float(x["i_int"][0])
    assert abs(before) < 50.0
    step(c, motor, p, x, 0j, omega_ref=sign * 100.0, u_dc=60.0, reserve=0.0)
    assert float(x["i_int"][0]) == pytest.approx(before, abs=1e-3)
    step(c, motor, p, x, 0j, omega_ref=-sign * 1e3, u_dc=60.0, reserve=0.0)
    for _ in range(300):
        step(c, motor, p, x, 0j, omega_ref=-sign * 1e3, u_dc=60.0, reserve=0.0)
    assert sign * float(x["i_ref"]["q"][0]) < 1.0


def test_speed_control_does_not_wind_up(c: Call, motor: Motor) -> None:
    """Two seconds at the current limit leave a bounded integrator and a small overshoot."""
    p, x = params(motor), rest()
    p["k_fw"] = 0.0
    k_t = 1.5 * motor.n_p**2 * motor.psi_f
    for _ in range(10_000):
        step(c, motor, p, x, 0j, omega=0.0, omega_ref=300.0, u_dc=AMPLE)
    assert abs(float(x["i_int"][0])) < 60.0
    omega, peak = 0.0, 0.0
    for _ in range(10_000):
        step(c, motor, p, x, 0j, omega=omega, omega_ref=300.0, u_dc=AMPLE)
        omega += motor.T_s * k_t * float(x["i_ref"]["q"][0]) / motor.J
        peak = max(peak, omega)
    assert omega == pytest.approx(300.0, rel=0.01)
    assert peak < 300.0 * 1.2


def test_speed_step_without_limits_does_not_overshoot(c: Call, motor: Motor) -> None:
    """The IP form follows a critically damped second order: 2 % within 5.9 / w, no overshoot."""
    p, x = params(motor, i_q_slew=1e6, mtpa=False), rest()
    k_t, speed = 1.5 * motor.n_p**2 * motor.psi_f, []
    omega, hertz = 0.0, derive(motor, DESIGN).speed_hz
    for _ in range(int(1.5 / motor.T_s)):
        step(c, motor, p, x, 0j, omega=omega, omega_ref=20.0, u_dc=AMPLE)
        omega += motor.T_s * k_t * float(x["i_ref"]["q"][0]) / motor.J
        speed.append(omega)
    t = motor.T_s * np.arange(1, len(speed) + 1)
    w = 2.0 * math.pi * hertz
    want = 20.0 * (1.0 - np.exp(-w * t) * (1.0 + w * t))
    assert np.max(speed) < 20.0 * 1.002
    assert np.max(np.abs(np.array(speed) - want)) < 0.02 * 20.0


def test_curve(c: Call, motor: Motor) -> None:
    """Linear between nodes, even in the current, constant beyond the last; nothing read beyond."""
    rng = np.random.default_rng(0)
    memory = np.full(12, np.nan, dtype=np.float32)
    memory[:9] = rng.normal(size=9)
    y = memory[:9]
    i_q = np.linspace(-12.0, 12.0, 997, dtype=np.float32)
    out = np.empty_like(i_q)
    c("curve", y, i_q, 8.0 / motor.i_max, out, len(i_q))
    want = np.interp(np.abs(i_q.astype(float)), np.linspace(0.0, motor.i_max, 9), y)
    assert np.max(np.abs(out - want)) < 3e-6

"""Inverter with a carrier: mean voltage, dead time, ripple, zero current, energy, convergence."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from sensorless.core.api import CARRIER_NAMES, PLANT, PLANT_STATE, SENSOR, Array
from sensorless.core.machine import carrier_run
from sensorless.design.records import plant_record
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor, Saturation

Call = Callable[..., None]
Map = Callable[[Saturation, Floats], Floats]
Complexes = np.ndarray[tuple[int], np.dtype[np.complex128]]

U_DC = 540.0
COLUMN = {name: j for j, name in enumerate(CARRIER_NAMES)}


def linear(motor: Motor) -> Motor:
    return replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))


def run(
    motor: Motor,
    u: Complexes,
    *,
    i_dq: complex = 0j,
    omega_m: float = 0.0,
    theta_e: float = 0.0,
    dead_time: float = 0.0,
    n_sub: int = 1,
    blocked: bool = True,
    u_dc: float = U_DC,
    tau_load: float = 0.0,
) -> dict[str, Floats]:
    """Columns of ``CARRIER_NAMES`` under the commands u, and the phase currents ``i_abc``."""
    sensor, plant = np.zeros(1, dtype=SENSOR), np.zeros(1, dtype=PLANT)
    state = np.zeros(1, dtype=PLANT_STATE)
    sensor["dead_time_share"] = dead_time / motor.T_s
    plant[0] = plant_record(motor)
    plant["h"], plant["n_sub"] = motor.T_s / n_sub, n_sub
    plant["inv_J"] = 0.0 if blocked else plant["inv_J"]
    psi = flux(motor.saturation, np.array([[i_dq.real, i_dq.imag]]))[0]
    state["psi_d"], state["psi_q"] = psi
    state["omega_m"], state["theta_e"] = omega_m, theta_e
    n = len(u)
    inputs = np.stack([u.real, u.imag, np.full(n, u_dc), np.full(n, tau_load)], axis=-1)
    rows = carrier_run(sensor, plant, state, inputs)
    out = {name: rows[:, j] for name, j in COLUMN.items()}
    i_ab = (out["i_d"] + 1j * out["i_q"]) * np.exp(1j * out["theta_e"])
    out["i_abc"] = np.stack([(i_ab * np.exp(-2j * np.pi * k / 3)).real for k in range(3)])
    return out


def mean_voltage(r: dict[str, Floats]) -> complex:
    u = (r["u_alpha"] + 1j * r["u_beta"])[:-1]
    return complex(np.sum(u * np.diff(r["t"])) / r["t"][-1])


def averaged(c: Call, u: complex, i: complex, dead_time_share: float) -> complex:
    p = np.zeros(1, dtype=SENSOR)
    p["dead_time_share"], p["inv_i_zero"] = dead_time_share, 1e6
    y = np.empty((1, 2), dtype=np.float32)
    u_ab, i_ab = (np.array([[z.real, z.imag]], dtype=np.float32) for z in (u, i))
    c("inverter", p, u_ab, U_DC, i_ab, y, 1)
    return complex(y[0, 0], y[0, 1])


@pytest.mark.parametrize("radius", [0.0, 5.0, 100.0, 311.0, 340.0, 600.0])
def test_mean_voltage_is_that_of_the_averaged_inverter(
    c: Call, motor: Motor, radius: float
) -> None:
    """Without dead time, in and beyond the linear range, to the rounding of the command."""
    for angle in np.linspace(0.0, 2.0 * math.pi, 50):
        u = radius * complex(math.cos(angle), math.sin(angle))
        got = mean_voltage(run(motor, np.array([u])))
        assert abs(got - averaged(c, u, 0j, 0.0)) < 2e-4


def test_an_active_vector_is_one_of_six(motor: Motor) -> None:
    """The voltage between the edges is zero or 2/3 u_dc in one of six directions."""
    r = run(motor, 200.0 * np.exp(1j * np.linspace(0.0, 6.0, 40)))
    u = r["u_alpha"] + 1j * r["u_beta"]
    active = np.abs(u) > 1e-9
    assert np.abs(u[active]) == pytest.approx(2.0 / 3.0 * U_DC)
    sixths = np.angle(u[active]) / (math.pi / 3.0)
    assert np.max(np.abs(sixths - np.rint(sixths))) < 1e-9
    assert len(np.unique(np.rint(sixths) % 6)) == 6
    assert not active[0]


@pytest.mark.parametrize("radius", [0.0, 60.0, 290.0])
def test_dead_time_at_large_currents_is_that_of_the_averaged_inverter(
    c: Call, motor: Motor, radius: float
) -> None:
    """Every leg loses u_dc t_d / T_s against its current, for any command and current direction."""
    share = 2e-6 / motor.T_s
    for angle in np.arange(12) * math.pi / 6.0 + 0.3:
        u = radius * complex(math.cos(angle), math.sin(angle))
        for turn in np.arange(6) * math.pi / 3.0 + math.pi / 6.0 + 0.3:
            i = 5.0 * complex(math.cos(turn), math.sin(turn))
            got = mean_voltage(run(motor, np.array([u]), i_dq=i, dead_time=2e-6))
            assert abs(got - averaged(c, u, i, share)) < 2e-4
            assert abs(got - u) > 0.9 * 4.0 / 3.0 * U_DC * share * math.cos(math.pi / 6.0)


def test_ripple_of_a_blocked_machine(motor: Motor) -> None:
    """The current moves by 2/3 u_dc t / L_d while one leg is high, and rests else."""
    m = replace(linear(motor), R_s=1e-9)
    u, L, T = 120.0, m.L_d, m.T_s
    r = run(m, np.array([u + 0j]))
    d_a, d_b = 0.5 + 0.75 * u / U_DC, 0.5 - 0.75 * u / U_DC
    edges = T * np.array([0, (1 - d_a) / 2, (1 - d_b) / 2, (1 + d_b) / 2, (1 + d_a) / 2, 1])
    slope = 2.0 / 3.0 * U_DC / L
    step = slope * T * (d_a - d_b) / 2.0
    assert r["t"] == pytest.approx(edges, abs=1e-12)
    assert r["i_d"] == pytest.approx([0, 0, step, step, 2 * step, 2 * step], abs=1e-9)
    assert 2 * step == pytest.approx(u * T / L)
    off_the_mean = r["i_d"] - u * r["t"] / L
    assert np.max(off_the_mean) == pytest.approx(u * T / L * (1 - d_a) / 2, rel=1e-9)
    assert np.ptp(off_the_mean) > 0.05


def test_samples_at_the_peak_of_the_carrier_see_no_ripple(motor: Motor) -> None:
    """Against the EMF at speed, the sampled current stays while it swings between the samples."""
    m = replace(linear(motor), R_s=1e-9, n_rated_rpm=1500.0)
    omega_e, periods = m.rpm_to_electrical(300.0), 50
    middle = (np.arange(periods) + 0.5) * omega_e * m.T_s
    half = 0.5 * omega_e * m.T_s
    emf = omega_e * m.psi_f * half / math.sin(half)
    r = run(m, 1j * emf * np.exp(1j * middle), omega_m=omega_e / m.n_p)
    at = np.isclose(r["t"] / m.T_s, np.rint(r["t"] / m.T_s), atol=1e-6)
    assert at.sum() == periods + 1
    swing = np.hypot(r["i_d"], r["i_q"])
    assert np.max(swing) > 0.02
    assert np.max(swing[at]) < 0.05 * np.max(swing)


def legs(u: complex) -> Floats:
    """Share of the period each leg is high: common mode in the middle of the three."""
    phase = np.array([(u * np.exp(-2j * np.pi * k / 3)).real for k in range(3)])
    return np.asarray(0.5 + (phase - 0.5 * (phase.max() + phase.min())) / U_DC)


def off(r: dict[str, Floats], u: complex, T_s: float, dead_time: float) -> Array:
    """Which leg's switches are off in which piece of the first period, (3, pieces)."""
    t = r["t"]
    from_middle = np.abs(0.5 * (t[:-1] + t[1:]) - 0.5 * T_s)
    edge = 0.5 * T_s * legs(u)
    return np.asarray(np.abs(from_middle[None] - edge[:, None]) < 0.5 * dead_time)


def test_a_diode_lets_no_current_turn_round(motor: Motor) -> None:
    """While its leg is off, a current keeps its direction or ends at zero, and none begins.

    At standstill without saliency: else the machine can drive a leg beyond the link.
    """
    m = replace(motor, saturation=Saturation.linear(0.1, 0.1, motor.psi_f))
    u, dead_time = 30.0 + 10.0j, 1e-5
    stopped = 0
    for angle in np.linspace(0.0, 2.0 * math.pi, 40):
        i = 0.015 * complex(math.cos(angle), math.sin(angle))
        r = run(m, np.array([u]), i_dq=i, dead_time=dead_time)
        is_off = off(r, u, m.T_s, dead_time)
        assert is_off.sum(axis=1).tolist() >= [2, 2, 2]
        before, after = r["i_abc"][:, :-1][is_off], r["i_abc"][:, 1:][is_off]
        assert np.min(np.sign(before) * after) > -1e-8
        none = np.abs(before) < 1e-8
        assert np.max(np.abs(after[none]), initial=0.0) < 1e-8
        stopped += int(np.sum((np.abs(before) > 1e-4) & (np.abs(after) < 1e-8)))
    assert stopped > 20


def test_with_all_switches_off_the_emf_drives_no_current(motor: Motor) -> None:
    """Below the link; the same machine with its terminals shorted carries some."""
    share = 0.4
    r = run(motor, np.array([0j]), omega_m=40.0, dead_time=share * motor.T_s)
    assert np.diff(r["t"]) / motor.T_s == pytest.approx([0.05, 0.4, 0.1, 0.4, 0.05])
    assert np.max(np.abs(r["i_abc"][:, [2, 4]])) < 1e-7
    assert np.max(np.abs(r["i_abc"][:, [1, 3]])) > 1e-3


def test_dead_time_loss_fades_around_zero_current(motor: Motor) -> None:
    """Ripple and clamping take the loss of a leg through zero without a step."""
    share = 2e-6 / motor.T_s
    lost = []
    for i in np.linspace(-0.06, 0.06, 41):
        r = run(motor, np.array([5.0 + 0j]), i_dq=complex(i, 0.0), dead_time=2e-6)
        lost.append((mean_voltage(r) - 5.0).real / (4.0 / 3.0 * U_DC * share))
    assert lost[0] == pytest.approx(1.0, abs=0.01)
    assert lost[-1] == pytest.approx(-1.0, abs=0.01)
    assert np.all(np.diff(lost) < 1e-6)
    assert np.max(-np.diff(lost)) < 0.2


def magnetic_energy(currents: Map, s: Saturation, start: Floats, end: Floats) -> float:
    """Work 3/2 int i dpsi along the straight line between two fluxes [J]."""

    def slope(x: float) -> float:
        return 1.5 * float(currents(s, start + x * (end - start)) @ (end - start))

    return float(quad(slope, 0.0, 1.0, epsabs=1e-13, epsrel=1e-13, limit=400)[0])


def simpson(y: Floats, t: Floats) -> float:
    """Integral over pieces of four equal steps; y is (pieces, 5)."""
    weights = np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12.0
    return float(np.sum(y @ weights * np.diff(t[:: y.shape[1] - 1])))


def test_energy_balance(motor: Motor, map_currents: Map) -> None:
    """Input from the link = copper + shaft + change of field energy, to 1e-8, with dead time."""
    u = 150.0 * np.exp(1j * np.linspace(0.0, 3.0, 100))
    r = run(
        motor,
        u,
        i_dq=-0.5 + 0.8j,
        omega_m=60.0,
        theta_e=-1.5,
        dead_time=3e-6,
        n_sub=4,
        blocked=False,
        tau_load=2.0,
    )
    pieces = (len(r["t"]) - 1) // 4
    rows = np.arange(pieces)[:, None] * 4 + np.arange(5)
    i_ab = (r["i_d"] + 1j * r["i_q"]) * np.exp(1j * r["theta_e"])
    held = (r["u_alpha"] + 1j * r["u_beta"])[rows[:, :1]]
    electrical = simpson(1.5 * (held * np.conj(i_ab[rows])).real, r["t"])
    copper = simpson(1.5 * motor.R_s * np.abs(i_ab[rows]) ** 2, r["t"])
    shaft = simpson((r["tau"] * r["omega_m"])[rows], r["t"])
    psi = np.stack([r["psi_d"], r["psi_q"]], axis=-1)
    field = magnetic_energy(map_currents, motor.saturation, psi[0], psi[-1])
    scale = abs(electrical) + copper + abs(shaft)
    assert min(copper, abs(shaft), abs(field)) > 1e-3 * scale, "a term is too small to be tested"
    assert abs(electrical - copper - shaft - field) < 1e-8 * scale


def test_fourth_order_from_edge_to_edge(motor: Motor) -> None:
    """Halving the Runge-Kutta step divides the error by 16; one step is enough for 1e-9 A."""
    m = replace(linear(motor), T_s=2e-3)
    u = 250.0 * np.exp(1j * np.linspace(0.0, 2.0, 6))

    def end(n_sub: int, machine: Motor = m) -> Floats:
        r = run(machine, u, i_dq=-1.0 + 3.0j, omega_m=90.0, n_sub=n_sub, blocked=False)
        return np.array([r["i_d"][-1], r["i_q"][-1]])

    exact = end(32)
    errors = [float(np.max(np.abs(end(n) - exact))) for n in (1, 2, 4)]
    assert errors[0] > 1e-9
    assert 11.0 < errors[0] / errors[1] < 23.0
    assert 11.0 < errors[1] / errors[2] < 23.0
    assert np.max(np.abs(end(1, motor) - end(8, motor))) < 1e-9

"""Harmonics, second saliency and iron loss of the machine against closed forms and its energy."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad, simpson

from sensorless.core.api import PLANT, PLANT_STATE, Array
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.trace import trace
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor, Saturation
from sensorless.policies.registry import make_policy

Map = Callable[[Saturation, Floats], Floats]

FIFTH, SEVENTH, SECOND = 0.04, -0.025, 0.06


def machine(motor: Motor, n_p: int = 2, **details: float) -> Array:
    """``plant_params_t`` of a motor with details as in a scenario, shape (1,)."""
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 1.0)
    for name, value in details.items():
        getattr(s, name)[:] = value
    plant = SimFactory(motor, DriveDesign()).build(s)["plant"].copy()
    assert plant["detail"][0] == 1 and n_p == motor.n_p
    return plant


def run(plant: Array, psi: complex, omega_m: float, theta: float, u: Array) -> Floats:
    """Rows of ``plant_run`` at the voltages u (n,), complex, on a shaft without a load."""
    state = np.zeros(1, dtype=PLANT_STATE)
    state["psi_d"], state["psi_q"] = psi.real, psi.imag
    state["omega_m"], state["theta_e"] = omega_m, theta
    u = np.asarray(u, dtype=complex)
    return plant_run(plant, state, np.stack([u.real, u.imag, np.zeros(len(u))], axis=-1))


def no_load_flux(motor: Motor, theta: Floats) -> Floats:
    """Stator flux (n,), complex, of three phases psi_f (cos + h_5/5 cos 5 + h_7/7 cos 7)."""
    out = np.zeros(len(theta), dtype=complex)
    for k in range(3):
        x = theta - 2.0 * math.pi * k / 3.0
        phase = np.cos(x) + FIFTH / 5.0 * np.cos(5.0 * x) + SEVENTH / 7.0 * np.cos(7.0 * x)
        out += 2.0 / 3.0 * motor.psi_f * phase * np.exp(2j * math.pi * k / 3.0)
    return np.asarray(out)


def test_no_load_emf_has_the_harmonics_asked_for(motor: Motor) -> None:
    """Fed with exactly that EMF, the spinning machine draws no current and makes no torque."""
    plant = machine(motor, emf_5=FIFTH, emf_7=SEVENTH, saliency_6=SECOND)
    plant["inv_J"], plant["h"] = 0.0, 1e-6
    omega_m = 150.0
    theta = 0.3 + motor.n_p * omega_m * 1e-6 * np.arange(3001.0)
    psi = no_load_flux(motor, np.asarray(theta, dtype=np.float64))
    rows = run(plant, psi[0] * np.exp(-0.3j), omega_m, 0.3, np.diff(psi) / 1e-6)
    assert np.abs(rows[:, :2]).max() < 1e-6
    assert np.abs(rows[:, 4]).max() < 2e-6
    assert np.ptp(np.abs(psi)) > 0.005 * motor.psi_f


def test_torque_is_the_power_of_the_emf(motor: Motor) -> None:
    """Of a linear machine: tau omega_m = sum e_a i_a over phases + reluctance torque."""
    linear = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    plant = machine(motor, emf_5=FIFTH, emf_7=SEVENTH)
    plant["map"]["a_d0"], plant["map"]["a_q0"] = linear.a_d0, linear.a_q0
    plant["map"]["i_f"] = linear.i_f
    for name in ("a_dd", "a_qq", "c_d", "c_q"):
        plant["map"][name] = 0.0
    for theta in np.linspace(-3.0, 3.0, 13):
        at = no_load_flux(motor, np.array([theta - 1e-6, theta, theta + 1e-6]))
        per_rad = (at[2] - at[0]) / 2e-6
        i = -1.3 + 2.7j
        psi = motor.L_d * i.real + 1j * motor.L_q * i.imag + at[1] * np.exp(-1j * theta)
        row = run(plant, psi, 0.0, theta, np.zeros(0))[0]
        i_ab = i * np.exp(1j * theta)
        wanted = (
            1.5
            * motor.n_p
            * ((per_rad * np.conj(i_ab)).real + (motor.L_d - motor.L_q) * i.real * i.imag)
        )
        assert row[:2] == pytest.approx([i.real, i.imag], abs=1e-9)
        assert row[4] == pytest.approx(wanted, abs=1e-7)


def second_axis(motor: Motor, theta: float) -> float:
    """Axis of least inductance against d: 1/2 atan2(g sin 6 theta, G + g cos 6 theta)."""
    difference = 0.5 * (1.0 / motor.L_d - 1.0 / motor.L_q)
    g = SECOND * difference
    return 0.5 * math.atan2(g * math.sin(6.0 * theta), difference + g * math.cos(6.0 * theta))


def test_the_second_saliency_turns_the_axis_of_least_inductance(motor: Motor) -> None:
    plant = machine(motor, saliency_6=SECOND)
    psi_0 = float(plant["harmonics"]["psi_0"][0])
    for theta in np.linspace(-3.0, 3.0, 25):
        columns = []
        for step in (1e-5, 1e-5j):
            ends = [run(plant, psi_0 + way * step, 0.0, theta, np.zeros(0))[0] for way in (1, -1)]
            columns.append((ends[0] - ends[1])[:2] / 2e-5)
        gamma = np.array(columns).T
        assert gamma[0, 1] == pytest.approx(gamma[1, 0], abs=1e-9), "reciprocal"
        axis = 0.5 * math.atan2(2.0 * gamma[0, 1], gamma[0, 0] - gamma[1, 1])
        assert axis == pytest.approx(second_axis(motor, theta), abs=1e-6)


@pytest.mark.parametrize("theta", [0.0, 0.2, 0.6, -1.0])
def test_injection_locks_on_that_axis(motor: Motor, theta: float) -> None:
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 0.6)
    s.theta_0[:], s.saliency_6[:], s.noise[:], s.J[:] = theta, SECOND, 0.0, 1e6
    s.dead_time[:] = 0.0

    def ideal(sim: Array) -> None:
        sim["sensor"]["lsb"], sim["sensor"]["inv_lsb"] = 1e-6, 1e6
        sim["control"]["control"]["u_dt"] = 0.0

    t = trace(make_policy("constant:1", motor), s, motor, DriveDesign(estimator="smo"), ideal)
    err = float(np.mean(t["theta_e_err_hfi"][-500:]))
    assert err == pytest.approx(-second_axis(motor, theta), abs=1e-3)
    assert abs(second_axis(motor, 0.2)) > 0.02


def test_iron_loss_at_rated_speed_without_load(motor: Motor) -> None:
    plant = machine(motor, p_iron=45.0)
    plant["inv_J"], plant["h"], plant["R_s"], plant["k_iron"] = 0.0, 1e-6, 0.0, 1.0
    omega = motor.omega_rated
    theta = omega * 1e-6 * np.arange(2001)
    psi = motor.psi_f * np.exp(1j * theta)
    rows = run(plant, complex(motor.psi_f), omega / motor.n_p, 0.0, np.diff(psi) / 1e-6)[1:]
    power = 1.5 * omega * motor.psi_f * rows[:, 1]
    assert power == pytest.approx(45.0, rel=1e-4)
    assert np.abs(rows[:, 0]).max() < 1e-3 and np.abs(rows[:, 4]).max() < 1e-5


def test_energy_is_neither_made_nor_lost(motor: Motor, map_currents: Map) -> None:
    """Electrical input = copper + iron loss + shaft work + change of field energy, to 1e-7.

    Everything but torque and motion is computed here, from the equations of ``harmonics.h``.
    """
    plant = machine(motor, emf_5=FIFTH, emf_7=SEVENTH, saliency_6=SECOND, p_iron=60.0)
    h, hold = 5e-6, 40
    plant["h"], plant["inv_J"] = h, 1.0 / 0.005
    p = {name: float(plant[name][0]) for name in ("R_s", "g_iron", "k_iron")}
    m_d, m_q, gamma, psi_0 = (
        float(plant["harmonics"][n][0]) for n in ("m_d", "m_q", "gamma", "psi_0")
    )

    def response(psi: Floats, theta: Floats) -> tuple[Floats, Floats]:
        """Currents of the flux, and its coordinates x beyond the magnet's harmonic."""
        c, s = np.cos(6.0 * theta), np.sin(6.0 * theta)
        x = psi - np.stack([m_d * c, m_q * s], axis=-1)
        z = gamma * (x[..., 0] - psi_0 - 1j * x[..., 1]) * (c + 1j * s)
        return map_currents(motor.saturation, x) + np.stack([z.real, z.imag], axis=-1), x

    def energy(psi: Floats, theta: float) -> float:
        x = response(psi, np.asarray(theta))[1]
        start = np.array([psi_0, 0.0])

        def slope(part: float) -> float:
            return float(map_currents(motor.saturation, start + part * (x - start)) @ (x - start))

        own = quad(slope, 0.0, 1.0, epsabs=1e-13, epsrel=1e-13, limit=400)[0]
        z = (x[0] - psi_0 + 1j * x[1]) ** 2 * np.exp(-6j * theta)
        return float(1.5 * (own + 0.5 * gamma * z.real))

    rng = np.random.default_rng(3)
    held = rng.uniform(-250.0, 250.0, 40) + 1j * rng.uniform(-250.0, 250.0, 40)
    start = flux(motor.saturation, np.array([[-1.0, 3.0]]))[0]
    rows = run(plant, complex(*start), 90.0, 0.4, np.repeat(held, hold))
    psi, tau, omega, theta = rows[:, 2:4], rows[:, 4], rows[:, 5], rows[:, 6]
    frame = np.exp(1j * theta)
    i_dq = response(psi, theta)[0]
    i = (i_dq[:, 0] + 1j * i_dq[:, 1]) * frame
    electrical = copper = iron = 0.0
    for k, u in enumerate(held):
        part = slice(hold * k, hold * (k + 1) + 1)
        e = p["k_iron"] * (u - p["R_s"] * i[part])
        whole = i[part] + p["g_iron"] * e
        electrical += simpson(1.5 * (u * np.conj(whole)).real, dx=h)
        copper += simpson(1.5 * p["R_s"] * np.abs(whole) ** 2, dx=h)
        iron += simpson(1.5 * p["g_iron"] * np.abs(e) ** 2, dx=h)
    shaft = simpson(tau * omega, dx=h)
    field = energy(psi[-1], theta[-1]) - energy(psi[0], theta[0])
    terms = (copper, iron, abs(shaft), abs(field))
    assert min(terms) > 1e-3 * sum(terms), "a term is too small to be tested"
    assert abs(electrical - copper - iron - shaft - field) < 1e-7 * sum(terms)
    kinetic = 0.5 * 0.005 * (omega[-1] ** 2 - omega[0] ** 2)
    assert abs(shaft - kinetic - motor.B * simpson(omega**2, dx=h)) < 1e-7 * sum(terms)


def test_hot_winding_and_hot_magnet(motor: Motor) -> None:
    """Copper 0.393 %/K; NdFeB -0.11 %/K, seen as the d flux of zero current."""
    s = Scenarios.nominal(motor, np.ones(2, dtype=np.uint64), 1.0)
    s.winding_K[1], s.magnet_K[1] = 100.0, 80.0
    sims = SimFactory(motor, DriveDesign()).build(s)
    assert sims["plant"]["R_s"][1] / motor.R_s == pytest.approx(1.393)
    assert sims["plant"]["map"]["i_f"][1] / motor.saturation.i_f == pytest.approx(0.912)
    cold, hot = sims["plant"]["harmonics"]["psi_0"]
    slope = (1.0 / motor.L_d) * motor.psi_f / motor.saturation.i_f
    assert hot / cold - 1.0 == pytest.approx(-0.088 / slope, rel=0.1)
    assert not sims["plant"]["detail"].any(), "both are only other numbers"


def test_details_at_zero_are_no_details(motor: Motor) -> None:
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 1.0)
    sim = SimFactory(motor, DriveDesign()).build(s)
    assert sim["plant"]["detail"][0] == 0 and sim["plant"]["k_iron"][0] == 1.0
    assert PLANT.itemsize % 8 == 0

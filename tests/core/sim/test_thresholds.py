"""Threshold voltages, dead time at the edges, ripple of the link: closed forms and the carrier."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import CARRIER_NAMES, PLANT_STATE, SENSOR, Array
from sensorless.core.machine import carrier_run, plant_run
from sensorless.design import records
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.metrics.catalogue import angle_err_max_deg
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.trace import trace
from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor
from sensorless.observers import flux_design
from sensorless.policies.registry import make_policy
from tests.helpers.drives import Alone
from tests.helpers.scenarios import lasting

Call = Callable[..., None]
U_DC, TRANSISTOR, DIODE = 540.0, 1.1, 0.7


def legs(u: complex) -> Array:
    """Leg voltages (3,) with the common mode that centres them."""
    phase = np.array([(u * np.exp(-2j * np.pi * k / 3)).real for k in range(3)])
    return np.asarray(phase - 0.5 * (phase.max() + phase.min()))


def vector(leg: Array) -> complex:
    return complex(2.0 / 3.0 * sum(x * np.exp(2j * np.pi * k / 3) for k, x in enumerate(leg)))


def expected(u: complex, i: complex) -> complex:
    """Each leg loses the drop of what conducts, for as long as it does."""
    leg, lost = legs(u), np.zeros(3)
    for k in range(3):
        high = 0.5 + leg[k] / U_DC
        out = (i * np.exp(-2j * np.pi * k / 3)).real > 0.0
        drop = (TRANSISTOR, DIODE) if out else (-DIODE, -TRANSISTOR)
        lost[k] = high * drop[0] + (1.0 - high) * drop[1]
    return u - vector(lost)


def sensor() -> Array:
    p = np.zeros(1, dtype=SENSOR)
    p["u_on"], p["u_skew"] = 0.5 * (TRANSISTOR + DIODE), TRANSISTOR - DIODE
    p["inv_i_zero"] = 1e6
    return p


CASES = [(0j, 3 + 1j), (120 - 40j, 3 + 1j), (-200 + 90j, -2 - 4j), (30 + 250j, 1 - 3j)]


def at_rest(motor: Motor, i: complex, theta: float = 0.0) -> tuple[Array, Array]:
    """A blocked machine with a current [A] in the rotor frame: its parameters and state."""
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 1.0)
    s.detailed[:] = True
    plant = SimFactory(motor, DriveDesign()).build(s)["plant"].copy()
    plant["inv_J"] = 0.0
    state = np.zeros(1, dtype=PLANT_STATE)
    state["psi_d"], state["psi_q"] = flux(motor.saturation, np.array([[i.real, i.imag]]))[0]
    state["theta_e"] = theta
    plant_run(plant, state, np.zeros((0, 3)))
    return plant, state


def averaged(c: Call, p: Array, plant: Array, state: Array, u: complex) -> complex:
    y = np.empty((1, 2), dtype=np.float32)
    c("edges", p, plant, state, np.array([[u.real, u.imag]], dtype=np.float32), U_DC, y, 1)
    return complex(y[0, 0], y[0, 1])


def switched(p: Array, plant: Array, state: Array, u: complex) -> complex:
    rows = carrier_run(p, plant, state.copy(), np.array([[u.real, u.imag, U_DC, 0.0]]))
    t, u_a, u_b = (rows[:, CARRIER_NAMES.index(name)] for name in ("t", "u_alpha", "u_beta"))
    return complex(np.sum((u_a + 1j * u_b)[:-1] * np.diff(t)) / t[-1])


@pytest.mark.parametrize(("u", "i"), CASES)
def test_each_leg_loses_the_threshold_of_what_conducts(
    c: Call, motor: Motor, u: complex, i: complex
) -> None:
    plant, state = at_rest(motor, i)
    assert averaged(c, sensor(), plant, state, u) == pytest.approx(expected(u, i), abs=1e-3)
    assert switched(sensor(), plant, state, u) == pytest.approx(expected(u, i), abs=1e-5)


def test_dead_time_at_small_currents_is_that_of_the_edges(c: Call, motor: Motor) -> None:
    """Random small currents, voltages with and without injection: a third of the error at most.

    Against the switching inverter; the other averaged one takes the current at the sample.
    """
    rng = np.random.default_rng(5)
    p = np.zeros(1, dtype=SENSOR)
    p["dead_time_share"], p["inv_i_zero"] = 0.01, 1.0 / (0.01 * motor.i_rated)
    new, old = [], []
    for k in range(300):
        i = complex(*rng.uniform(-0.15, 0.15, 2))
        theta = rng.uniform(-3.0, 3.0)
        u = complex(*rng.uniform(-40.0, 40.0, 2)) + (k % 3 - 1) * 50.0 * np.exp(1j * theta)
        plant, state = at_rest(motor, i, theta)
        truth = switched(p, plant, state, u)
        new.append(abs(averaged(c, p, plant, state, u) - truth))
        y, i_ab = np.empty((1, 2), dtype=np.float32), i * np.exp(1j * theta)
        pair = [np.array([[z.real, z.imag]], dtype=np.float32) for z in (u, i_ab)]
        c("inverter", p, pair[0], U_DC, pair[1], y, 1)
        old.append(abs(complex(y[0, 0], y[0, 1]) - truth))
    rms = [float(np.sqrt(np.mean(np.square(x)))) for x in (new, old)]
    assert rms[0] < rms[1] / 3.0, rms


def test_unload_slips_where_it_does_on_the_switching_inverter(
    motor: Motor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Largest angle errors of a flux observer that injection does not hold.

    Dead time near zero current decides its slips. With injection there are none to compare.
    """
    monkeypatch.setattr(flux_design, "APART", math.inf)
    monkeypatch.setattr(records, "designed", records.designed.__wrapped__)  # kept without APART
    policy = make_policy("reference-flux", motor)
    policy.settings = {}
    s = lasting(1.6)("unload", motor, 11, 12)
    s.psi_f[:], s.R_s[:], s.J[:], s.dead_time[:] = 1.0, 1.0, 1.0, motor.dead_time
    peaks = []
    for detailed, carrier in ((True, True), (True, False), (False, False)):
        s.detailed[:] = detailed
        design = DriveDesign(estimator="flux", flux_L_q_bias=0.7, carrier=carrier)
        peaks.append(angle_err_max_deg(rollout(policy, s, Alone(motor, design))))
    near, far = (float(np.corrcoef(peaks[0], x)[0, 1]) for x in peaks[1:])
    assert near > 0.9 > far, (near, far)


def test_the_link_ripples_as_asked_and_the_pulses_come_too_late(motor: Motor) -> None:
    """300 Hz: the drive measures the ripple at k, its pulses act one and a half periods later."""
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 0.2)
    s.ripple[:], s.ripple_hz[:], s.ripple_phase[:] = 0.03, 300.0, 1.0
    t = trace(make_policy("sensored", motor), s, motor, DriveDesign())
    wanted = motor.u_dc * (1.0 + 0.03 * np.cos(2.0 * np.pi * 300.0 * t["t"] + 1.0))
    assert t["u_dc"] == pytest.approx(wanted, rel=1e-6)


def test_ripple_of_any_length_keeps_its_phase(c: Call) -> None:
    """An integer phase: exact after an hour."""
    p = np.zeros(1, dtype=SENSOR)
    p["ripple"], p["ripple_phase"], p["ripple_half_step"] = 1.0, 2**30, round(2**32 * 0.03)
    half = np.array([0, 1, 7, 36_000_000], dtype=np.int32)
    y = np.empty(4, dtype=np.float32)
    c("link_ripple", p, half, y, 4)
    turns = 0.25 + half * (round(2**32 * 0.03) / 2**32)
    assert y == pytest.approx(np.cos(2.0 * np.pi * (turns % 1.0)), abs=1e-6)


def test_a_link_that_moves_between_measurement_and_pulse_moves_the_voltage(motor: Motor) -> None:
    """Voltage over [k, k+1] = command times link(k + 1/2) / link(k - 1): seen as 300 Hz in i_q."""
    s = Scenarios.nominal(motor, np.ones(1, dtype=np.uint64), 0.3)
    s.noise[:], s.dead_time[:], s.J[:] = 0.0, 0.0, 1e6
    s.omega_0[:] = 0.4 * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]

    def open_loop(sim: Array) -> None:
        sim["sensor"]["lsb"], sim["sensor"]["inv_lsb"] = 1e-6, 1e6
        sim["control"]["control"]["u_dt"] = 0.0
        for gain in ("k_p_d", "k_p_q", "k_i_d", "k_i_q"):
            sim["control"]["control"][gain] *= 1e-3

    runs = []
    for s.ripple[:], s.ripple_hz[:] in ((0.0, 0.0), (0.03, 300.0)):
        runs.append(trace(make_policy("sensored", motor), s, motor, DriveDesign(), open_loop))
    wave = np.exp(-2j * np.pi * 300.0 * runs[0]["t"][500:])
    seen = 2.0 * abs(np.mean((runs[1]["i_q"] - runs[0]["i_q"])[500:] * wave))
    emf = 0.4 * motor.omega_rated * motor.psi_f
    late = 2.0 * np.sin(np.pi * 300.0 * 1.5 * motor.T_s)
    wanted = emf * 0.03 * late / (2.0 * np.pi * 300.0 * motor.L_q)
    assert seen == pytest.approx(wanted, rel=0.02)

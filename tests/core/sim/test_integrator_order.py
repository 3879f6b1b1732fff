"""The plant's integrator: its order, and an independent one of much higher order."""

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sensorless.core.machine import plant_run
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor, Saturation
from sensorless.plant.case import PlantCase
from sensorless.plant.run import integrate, plant_arrays, run_case
from tests.helpers.machines import BRIDGE

Map = Callable[[Saturation, Floats], Floats]

STEEP = replace(BRIDGE, U=2, V=2)
PERIOD = 1e-3


def case_of(saturation: Saturation, held: bool) -> PlantCase:
    """A turning machine with current; its flux keeps away from the kinks of |psi|."""
    return PlantCase(
        T_s=PERIOD,
        n_p=2,
        R_s=0.63,
        saturation=saturation,
        J=math.inf if held else 0.01,
        B=0.0 if held else 0.01,
        i_d=-1.0,
        i_q=4.0,
        theta_e=2.0,
        omega_m=90.0,
    )


def voltages(case: PlantCase, periods: int) -> Floats:
    """Voltages (n, 3) near the EMF with an alternating part, and a load."""
    psi_f = flux(case.saturation, np.zeros((1, 2)))[0, 0]
    k = np.arange(periods)
    theta = case.theta_e + case.n_p * case.omega_m * case.T_s * (k + 0.5)
    emf = case.n_p * case.omega_m * psi_f
    along = 40.0 * (-1.0) ** k
    return np.stack(
        [
            along * np.cos(theta) - emf * np.sin(theta),
            along * np.sin(theta) + emf * np.cos(theta),
            np.full(periods, 3.0),
        ],
        axis=-1,
    )


def end_state(case: PlantCase, inputs: Floats, sub_steps: int) -> Floats:
    plant, state = plant_arrays(case, sub_steps)
    return np.asarray(plant_run(plant, state, inputs)[-1, [2, 3, 5, 6]])


def oracle(case: PlantCase, inputs: Floats, currents: Map, turning: bool) -> Floats:
    """Flux, speed and angle (n + 1, 4) by an adaptive method of order 8, period by period.

    ``turning``: the voltage is held in the stator frame, as it is; else in the rotor frame.
    """
    psi = flux(case.saturation, np.array([[case.i_d, case.i_q]]))[0]
    state = np.array([psi[0], psi[1], case.omega_m, case.theta_e])
    rows = [state]
    for u_alpha, u_beta, tau_load in inputs:
        start = state[3]

        def rate(
            t: float,
            y: Floats,
            u: complex = complex(u_alpha, u_beta),
            start: float = start,
            load: float = tau_load,
        ) -> list[float]:
            i = currents(case.saturation, y[:2])
            seen = u * np.exp(-1j * (y[3] if turning else start))
            omega = case.n_p * y[2]
            tau = 1.5 * case.n_p * (y[0] * i[1] - y[1] * i[0])
            return [
                seen.real - case.R_s * i[0] + omega * y[1],
                seen.imag - case.R_s * i[1] - omega * y[0],
                (tau - case.B * y[2] - load) / case.J,
                omega,
            ]

        state = solve_ivp(rate, (0.0, case.T_s), state, method="DOP853", rtol=1e-12, atol=1e-13).y[
            :, -1
        ]
        rows.append(state)
    return np.array(rows)


MACHINES = ("linear", "saturated", "bridge")


def machine(name: str, motor: Motor) -> Saturation:
    linear = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    return {"linear": linear, "saturated": motor.saturation, "bridge": STEEP}[name]


@pytest.mark.parametrize("held", [False, True], ids=["free", "held"])
@pytest.mark.parametrize("name", MACHINES)
def test_order_is_four(name: str, held: bool, motor: Motor) -> None:
    """Halving the step divides the error by at least 2^3.8."""
    case = case_of(machine(name, motor), held)
    inputs = voltages(case, 4)
    exact = end_state(case, inputs, 256)
    errors = [float(np.max(np.abs(end_state(case, inputs, n) - exact))) for n in (4, 8, 16)]
    assert errors[2] > 1e-13, "the errors are round-off, nothing is measured"
    for coarse, fine in pairwise(errors):
        assert math.log2(coarse / fine) >= 3.8


@pytest.mark.parametrize("name", MACHINES)
def test_agrees_with_an_independent_method(name: str, motor: Motor, map_currents: Map) -> None:
    """Non-zero start, free shaft: within 1e-8 of SciPy's DOP853 at every instant."""
    case = case_of(machine(name, motor), held=False)
    inputs = voltages(case, 12)
    got = run_case(case, inputs).rows
    want = oracle(case, inputs, map_currents, turning=True)
    assert np.max(np.abs(got[:, [8, 9, 11]] - want[:, :3])) < 1e-8
    assert np.max(np.abs(np.angle(np.exp(1j * (got[:, 12] - want[:, 3]))))) < 1e-8
    assert np.max(np.abs(got[:, 1:3] - map_currents(case.saturation, want[:, :2]))) < 1e-7


def test_voltage_is_held_in_the_stator_frame(motor: Motor, map_currents: Map) -> None:
    """A voltage that turned with the rotor within a period would be seen."""
    case = case_of(motor.saturation, held=False)
    inputs = voltages(case, 4)
    got = integrate(case, inputs, split=8)
    turning, fixed = (oracle(case, inputs, map_currents, turning=t)[-1, :2] for t in (True, False))
    assert np.max(np.abs(got[-1, 2:4] - turning)) < 1e-8
    assert np.max(np.abs(got[-1, 2:4] - fixed)) > 1e-4


def test_long_periods_get_shorter_steps(motor: Motor) -> None:
    """A run whose default step is too long for its dynamics is split until it is right."""
    stiff = replace(case_of(Saturation.linear(5e-5, 8e-5, 0.005), held=True), R_s=0.1, i_q=10.0)
    inputs = np.tile([0.5, 1.0, 0.0], (20, 1))
    run = run_case(stiff, inputs)
    assert run.sub_steps > 8
    assert run.step_error < 1e-6
    finest = integrate(stiff, inputs, split=512)
    assert np.max(np.abs(run.rows[:, 1:3] - finest[:, :2])) < 1e-7
    assert np.max(np.abs(integrate(stiff, inputs)[:, :2] - finest[:, :2])) > 1e-6

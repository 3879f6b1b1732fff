"""The sliding-mode observer in the loop against its closed forms. Angles: estimate minus truth."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from sensorless.core.api import CURVE_N, Array
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.evaluation.steady import make_ideal, steady
from sensorless.evaluation.trace import lost_cause, trace
from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor
from sensorless.observers.smo_design import deadbeat_gain
from sensorless.policies.registry import make_policy
from sensorless.units import RPM_TO_RAD_S

FIXED = DriveDesign(
    estimator="smo", L_q_table=False, L_q_bias=1.0, mtpa=False, cross="none", speed_hz=1.0
)

SPEEDS = (300.0, 350.0, 600.0, 1000.0)
LOADS = (-5.0, -2.0, 0.0, 3.0, 6.0)


@pytest.mark.parametrize(
    ("generator", "motoring"), [(0.7, 0.7), (0.7, 0.9), (0.85, 0.7), (1.0, 1.0)]
)
@pytest.mark.parametrize("R_s", [0.8, 1.0, 1.2])
def test_closed_form(motor: Motor, generator: float, motoring: float, R_s: float) -> None:
    """Angle error over speed, load, resistance and L_q error, at the currents that flow.

    err = atan2(w (psi_q - L_q_hat i_q) - dR i_d, w (psi_d - L_q_hat i_d) + dR i_q)

    As a motor L_q_hat rises by the first node of its curve, and never falls.
    """

    def change(sims: Array) -> None:
        make_ideal(sims)
        sims["plant"]["R_s"] *= R_s

    rpm, tau = np.array(list(product(SPEEDS, LOADS))).T
    design = replace(FIXED, L_q_bias=generator, L_q_motoring=motoring)
    run = steady(motor, design, rpm, tau, 0.0, settle=3.0, change=change)
    assert run.held.all()
    i_d, i_q = run.i.T
    psi = flux(motor.saturation, run.i)
    w, dR = motor.n_p * rpm * RPM_TO_RAD_S, (R_s - 1.0) * motor.R_s
    share = np.clip(i_q * (CURVE_N - 1) / motor.i_max, 0.0, 1.0)
    L_q_hat = (generator + share * max(0.0, motoring - generator)) * motor.L_q
    expected = np.arctan2(
        w * (psi[:, 1] - L_q_hat * i_q) - dR * i_d, w * (psi[:, 0] - L_q_hat * i_d) + dR * i_q
    )
    np.testing.assert_allclose(np.rad2deg(-run.err), np.rad2deg(expected), atol=0.5)


@pytest.mark.parametrize(("g", "lag", "within"), [(125.0, -8.0, 0.5), (315.0, -3.2, 0.3)])
@pytest.mark.parametrize("lag_cure", [False, True])
def test_sigmoid_lag(motor: Motor, g: float, lag: float, within: float, lag_cure: bool) -> None:
    """At 300 r/min, before and after the cure."""
    design = replace(FIXED, smo_gain=g / deadbeat_gain(motor), lag_cure=lag_cure)
    run = steady(motor, design, [300.0, -300.0], [0.0, 0.0], 0.0, change=make_ideal)
    err = np.rad2deg(-run.err) * [1.0, -1.0]
    assert run.held.all()
    if lag_cure:
        assert np.all(np.abs(err) < 0.3)
    else:
        assert err == pytest.approx([lag, lag], abs=within)


@pytest.mark.parametrize("seed", [0, 1])
def test_warm_start(motor: Motor, seed: int) -> None:
    """Slaved to the drive below its floor, the observer takes up at a smaller error than without.

    From rest on injection to 300 r/min against 5 N m that help; the window starts at 60 r/min.
    """
    s = Scenarios.nominal(motor, np.array([seed], dtype=np.uint64), 1.2)
    s.t[:, 1], s.omega[:, 1:], s.omega_rate[:] = 0.5, 300.0 * RPM_TO_RAD_S, 300.0 * RPM_TO_RAD_S
    s.tau[:], s.tau_rate[:] = -5.0, 50.0
    worst = []
    for floor in (40.0, 0.0):
        t = trace(
            make_policy("hfi", motor), s, motor, DriveDesign(estimator="smo", smo_floor_rpm=floor)
        )
        assert lost_cause(t) is None
        start = int(np.argmax(t["omega_m"] > 60.0 * RPM_TO_RAD_S))
        worst.append(np.max(np.abs(t["theta_e_err_smo"][start : start + 500])))
    warm, cold = worst
    assert warm < 0.75 * cold


def test_bounds(motor: Motor) -> None:
    """The estimated speed stops at its bound, the EMF at k; both are settings."""
    base = control_record(motor, DriveDesign(estimator="smo"))
    assert base["smo"]["k"] == pytest.approx(2.5 * motor.omega_rated * motor.psi_f)
    tight = DriveDesign(
        estimator="smo", speed_bound=0.5, smo_k=400.0 / (motor.omega_rated * motor.psi_f)
    )
    record = control_record(motor, tight)
    assert record["smo"]["k"] == pytest.approx(400.0)
    assert record["smo"]["k"] * record["smo"]["half_a"] == pytest.approx(deadbeat_gain(motor))
    assert {float(record[name]["pll"]["omega_max"]) for name in ("hfi", "smo", "flux")} == {
        np.float32(0.5 * motor.omega_rated)
    }
    free = control_record(motor, DriveDesign(estimator="smo", speed_bound=np.inf))["smo"]["pll"][
        "omega_max"
    ]
    assert 1e30 < free < np.inf
    s = Scenarios.nominal(motor, np.zeros(1, np.uint64), 0.5)
    s.omega_0[:] = s.omega[:] = 1000.0 * RPM_TO_RAD_S
    t = trace(make_policy("smo", motor), s, motor, tight)
    assert np.max(np.abs(t["omega_m_hat"][1:])) <= 0.5001 * motor.omega_rated / motor.n_p

"""The estimator that does not lead follows the one that does, in the closed loop."""

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import Floats
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

CORRECTION = 0.5
"""The leader's own loop moves it by k_p T_s times its noisy error signal in a period, which the
other one learns a period later [deg]."""


def wrapped(x: Array) -> Array:
    return np.asarray(np.abs(np.angle(np.exp(1j * np.asarray(x, dtype=np.float64)))))


def gap(motor: Motor, rpm: Floats, tau: float, k_s: float) -> Floats:
    """Largest difference of the two angles, a row a period, once the run has settled [deg]."""
    n = len(rpm)
    s = Scenarios.nominal(motor, np.arange(n, dtype=np.uint64), 2.0)
    s.omega_0 = rpm * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    s.tau[:], s.tau_rate[:] = tau, 20.0
    sims = SimFactory(motor, DriveDesign(estimator="smo")).build(s)
    weight, obs = np.full(n, k_s, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, round(0.8 / motor.T_s), weight, obs)
    worst = np.zeros(n)
    for _ in range(300):
        sim_run(sims, 1, weight, obs)
        x = sims["drive"]["x"]
        worst = np.maximum(worst, wrapped(x["theta_hfi"] - x["theta_smo"]))
    assert (sims["lost"] == 0).all()
    valid = sims["drive"]["x"]["hfi" if k_s == 0.0 else "emf"]["valid"]
    assert (valid == 0.0).all(), "the idle estimator has no signal of its own here"
    return np.asarray(np.rad2deg(worst))


@pytest.mark.parametrize("tau", [0.0, 6.0])
def test_injection_estimator_follows_while_there_is_no_injection(motor: Motor, tau: float) -> None:
    """The weight is 0; cross-coupling included, in both directions."""
    assert gap(motor, np.array([-900.0, -500.0, 500.0, 900.0]), tau, 0.0).max() < CORRECTION


@pytest.mark.parametrize("tau", [0.0, 6.0])
def test_emf_estimator_follows_below_its_floor(motor: Motor, tau: float) -> None:
    """The weight is 1, the EMF too small."""
    assert gap(motor, np.array([-25.0, 0.0, 25.0]), tau, 1.0).max() < CORRECTION


def test_nothing_steps_when_injection_returns(motor: Motor) -> None:
    """From k_s 0 to 1 at 500 r/min: less than 1 degree a period beyond the speed."""
    s = Scenarios.nominal(motor, np.arange(1, dtype=np.uint64), 2.0)
    s.omega_0[:] = s.omega[:] = 500.0 * RPM_TO_RAD_S
    s.tau[:], s.tau_rate[:] = 6.0, 20.0
    sims = SimFactory(motor, DriveDesign(estimator="smo")).build(s)
    obs = np.zeros((1, SIGNAL_N), np.float32)
    sim_run(sims, round(0.8 / motor.T_s), np.zeros(1, np.float32), obs)
    was = sims["drive"]["x"]["est"]["theta"].copy()
    step = []
    for _ in range(500):
        sim_run(sims, 1, np.ones(1, np.float32), obs)
        now = sims["drive"]["x"]["est"]["theta"].copy()
        step.append(float(np.angle(np.exp(1j * (now - was)))[0]))
        was = now
    even = 500.0 * RPM_TO_RAD_S * motor.n_p * motor.T_s
    assert np.abs(np.rad2deg(np.array(step) - even)).max() < 1.0
    assert sims["drive"]["x"]["k_s"][0] == 1.0

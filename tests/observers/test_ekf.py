"""The extended Kalman filter: its model, and what it finds on machines without and with errors."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.machine import plant_run
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor
from sensorless.observers.ekf import MachineEkf, run_ekf
from sensorless.plant.case import PlantCase
from sensorless.plant.run import plant_arrays

MOTOR = Motor.load("paper")


def turning(rpm: float, i_dq: complex, periods: int, theta: float) -> tuple[Floats, Floats, Floats]:
    """Voltage before each sample, current and angle at it, of a machine at constant speed."""
    omega_m = rpm * math.pi / 30.0
    case = PlantCase(
        T_s=MOTOR.T_s,
        n_p=MOTOR.n_p,
        R_s=MOTOR.R_s,
        saturation=MOTOR.saturation,
        J=math.inf,
        B=0.0,
        i_d=i_dq.real,
        i_q=i_dq.imag,
        theta_e=theta,
        omega_m=omega_m,
    )
    omega = MOTOR.n_p * omega_m
    psi = complex(*flux(MOTOR.saturation, np.array([[i_dq.real, i_dq.imag]]))[0])
    middle = theta + omega * MOTOR.T_s * (np.arange(periods) + 0.5)
    u = (1j * omega * psi + MOTOR.R_s * i_dq) * np.exp(1j * middle)
    inputs = np.stack([u.real, u.imag, np.zeros(periods)], axis=-1)
    plant, state = plant_arrays(case, 4)
    rows = plant_run(plant, state, inputs)
    i = (rows[:, 0] + 1j * rows[:, 1]) * np.exp(1j * rows[:, 6])
    u_before = np.concatenate([np.zeros((1, 2)), inputs[:, :2]])
    return u_before, np.stack([i.real, i.imag], axis=-1), rows[:, 6]


def degrees(truth: Floats, estimate: Floats) -> Floats:
    return np.asarray(np.rad2deg(np.angle(np.exp(1j * (truth - estimate)))))


@pytest.mark.parametrize("rpm", [300.0, -900.0])
def test_exact_machine(rpm: float) -> None:
    """From 20 degrees and 10 % of speed off, within 0.1 degree and 0.5 % after 0.2 s."""
    u, i, theta = turning(rpm, -1.0 + 3.0j, 2000, 0.5)
    omega = MOTOR.rpm_to_electrical(rpm)
    theta_hat, omega_hat = run_ekf(MOTOR, u, i, 0.5 + math.radians(20.0), 0.9 * omega)
    assert abs(degrees(theta, theta_hat)[0]) > 3.0
    assert np.max(np.abs(degrees(theta, theta_hat)[1000:])) < 0.1
    assert np.max(np.abs(omega_hat[1000:] / omega - 1.0)) < 5e-3


def test_it_follows_the_map_and_not_the_data_sheet() -> None:
    """A machine without its saturation is another one: the angle shows it."""
    u, i, theta = turning(300.0, -1.0 + 3.0j, 2000, 0.5)
    other = replace(MOTOR, saturation=replace(MOTOR.saturation, a_qq=0.0, a_dq=0.0))
    theta_hat, _ = run_ekf(other, u, i, 0.5, MOTOR.rpm_to_electrical(300.0))
    assert np.min(np.abs(degrees(theta, theta_hat)[1000:])) > 2.0


def test_jacobian_of_the_measurement() -> None:
    """Against central differences of the measurement itself, at an arbitrary state."""
    ekf = MachineEkf(MOTOR, 0.4, 10.0)
    x = np.array([[0.7], [0.8], [30.0], [1.1]])
    _, jacobian = ekf.measured(x)
    for j, step in enumerate((1e-5, 1e-5, 1e-3, 1e-5)):
        shift = np.zeros((4, 1))
        shift[j] = step
        slope = (ekf.measured(x + shift)[0] - ekf.measured(x - shift)[0]) / (2.0 * step)
        assert jacobian[:, [j]] == pytest.approx(slope, abs=1e-5 * np.max(np.abs(jacobian)))


def test_machine_without_current_starts_without_current() -> None:
    i, _ = MachineEkf(MOTOR, 2.0, 0.0).measured(MachineEkf(MOTOR, 2.0, 0.0).filter.x)
    assert np.max(np.abs(i)) < 1e-9


@pytest.mark.filterwarnings("ignore::scipy.linalg.LinAlgWarning")
def test_a_filter_that_diverges_says_so_and_ends_nothing() -> None:
    motor = Motor.load("paper")
    u, i = np.zeros((8, 2)), np.zeros((8, 2))
    u[3] = 1e30
    theta, omega = run_ekf(motor, u, i, 0.0, 0.0)
    assert np.isfinite(theta[:3]).all() and np.isnan(theta[4:]).all() and np.isnan(omega[4:]).all()

"""The shipped machines: data-sheet values beside the flux map, and drives that run."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.control import design_curves, operating_line
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.steady import steady
from sensorless.machine.magnetics import (
    Floats,
    apparent_q_inductance,
    flux,
    inverse_inductance,
    torque,
)
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy

NAMES = sorted(path.stem for path in MOTORS.glob("*.toml"))
DRIVEN = ("ipmsm_2200w", "paper", "pmsyrm_5600w")
"""Machines that the default design drives; of the others ``motor check`` says that it does not."""


@pytest.mark.parametrize("name", NAMES)
def test_data_sheet_is_the_flux_map_at_zero_current(name: str) -> None:
    motor = Motor.load(name)
    psi = flux(motor.saturation, np.zeros((1, 2)))
    L = np.linalg.inv(inverse_inductance(motor.saturation, psi)[0])
    assert psi[0] == pytest.approx([motor.psi_f, 0.0], rel=1e-4, abs=1e-9)
    assert [L[0, 0], L[1, 1], L[0, 1]] == pytest.approx(
        [motor.L_d, motor.L_q, 0.0], rel=1e-4, abs=1e-9
    )


@pytest.mark.parametrize("name", NAMES)
def test_rated_torque_needs_about_rated_current(name: str) -> None:
    """Nameplate and flux map belong to the same machine; the limits leave room."""
    motor = Motor.load(name)
    line = operating_line(motor, True)
    need = float(np.interp(motor.tau_rated, torque(motor, line), np.hypot(*line.T)))
    assert 0.7 * motor.i_rated < need < 1.1 * motor.i_rated < motor.i_max


@pytest.mark.parametrize("name", NAMES)
def test_saliency_holds_on_the_operating_line(name: str) -> None:
    """Injection needs L_d clearly below L_q up to the current limit, along the magnetic axes."""
    motor = Motor.load(name)
    line = operating_line(motor, True)
    line = line[np.hypot(*line.T) <= motor.i_max]
    gamma = inverse_inductance(motor.saturation, flux(motor.saturation, line))
    low, high = np.linalg.eigvalsh(gamma).T
    assert np.all(low / high < 0.75)
    curves = design_curves(motor, operating_line(motor, True), L_q_table=True, cross="table")
    assert all(np.isfinite(curve).all() for curve in curves)


def error_of_bias(motor: Motor, design: DriveDesign, *bias: float) -> Floats:
    """Angle errors [deg] at rated torque of observers whose q inductance is biased by factors."""
    line = operating_line(motor, design.mtpa)
    i = np.array([[np.interp(motor.tau_rated, torque(motor, line), x) for x in line.T]])
    psi, L_q = flux(motor.saturation, i), np.array(bias) * apparent_q_inductance(motor, i)
    err = np.arctan2(psi[:, 1] - L_q * i[:, 1], psi[:, 0] - L_q * i[:, 0])
    return np.asarray(np.rad2deg(err))


@pytest.mark.parametrize("name", DRIVEN)
def test_each_of_the_papers_estimators_holds_rated_torque(name: str) -> None:
    """Injection at 10 % of rated speed, the observer at 30 %, in both directions of torque.

    The mean of the observer's errors as a generator and as a motor is that of its two q
    inductances; dead time shifts both by the same angle.
    """
    design = DriveDesign(estimator="smo")
    motor = Motor.load(name)
    tau = motor.tau_rated * np.array([-1.0, 0.0, 1.0])
    low = steady(motor, design, 0.1 * motor.n_rated_rpm, tau, 1.0, settle=2.5)
    high = steady(motor, design, 0.3 * motor.n_rated_rpm, tau, 0.0, settle=2.5)
    assert low.held.all() and high.held.all()
    assert np.all(np.abs(np.rad2deg(low.err)) < 1.5)
    want = np.mean(error_of_bias(motor, design, design.L_q_bias, design.L_q_motoring))
    odd = 0.5 * np.rad2deg(high.err[0] - high.err[2])
    assert odd == pytest.approx(float(want), abs=0.5)
    assert np.all(np.rad2deg(low.err_std) < 2.0)
    assert np.all(np.rad2deg(high.err_std) < 2.5), "a weak magnet's EMF hunts without load"


@pytest.mark.parametrize("name", DRIVEN)
def test_the_default_drive_holds_rated_torque(name: str) -> None:
    """All the weight at 10 % of rated speed, none at 30 %: the error is odd in the torque there.

    Its odd part is that of the biased q inductance, as on a flux observer, less what is known of it
    before any was learned: 4.5 % of L_q, from a fifth of rated speed on falling with the speed.
    """
    design = DriveDesign()
    motor = Motor.load(name)
    tau = motor.tau_rated * np.array([-1.0, 0.0, 1.0])
    low = steady(motor, design, 0.1 * motor.n_rated_rpm, tau, 1.0, settle=2.5)
    high = steady(motor, design, 0.3 * motor.n_rated_rpm, tau, 0.0, settle=2.5)
    assert low.held.all() and high.held.all()
    assert np.all(np.abs(np.rad2deg(low.err)) < 1.5)
    (want,) = error_of_bias(motor, design, derive(motor, design).coupled_L_q_bias)
    want -= np.rad2deg(0.045 * (0.2 / 0.3) * motor.L_q * motor.i_rated / motor.psi_f)
    odd = 0.5 * np.rad2deg(high.err[0] - high.err[2])
    assert odd == pytest.approx(float(want), abs=2.5)
    assert np.all(np.rad2deg(low.err_std) < 2.0)
    assert np.all(np.rad2deg(high.err_std) < 2.5)


def test_motors_suite_is_handoff_and_stress_in_turn() -> None:
    """Row by row the scenarios that those suites build, whatever the size."""
    motor = Motor.load("ipmsm_2200w")
    mixed = suite("motors", motor, 3, 11)
    stress = suite("stress-1", motor, 3, 11)
    np.testing.assert_array_equal(mixed.omega[1::2], stress.omega[1::2])
    np.testing.assert_array_equal(mixed.R_s[::2], np.ones(6))
    np.testing.assert_array_equal(mixed.omega[:5], suite("motors", motor, 3, 5).omega)
    run = rollout(
        make_policy("eq25", motor), mixed, SimFactory(motor, replace(DriveDesign(), k_s_slew=50.0))
    )
    assert not run.lost.any()

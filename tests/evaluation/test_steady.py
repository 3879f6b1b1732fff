"""Drives held at constant speed and load: what settles agrees with the machine's own equations."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.steady import Steady, constant, make_ideal, steady
from sensorless.machine.magnetics import cross_angle, torque
from sensorless.machine.motor import Motor

RPM = np.array([300.0, -300.0, 600.0])
TAU = np.array([7.0, 7.0, -4.0])


@pytest.fixture(scope="module")
def rough() -> Motor:
    """With friction of 2 N m at rated speed."""
    motor = Motor.load("paper")
    return replace(motor, B=2.0 / (1500.0 * np.pi / 30.0))


@pytest.fixture(scope="module")
def settled(rough: Motor) -> Steady:
    return steady(rough, DriveDesign(), RPM, TAU, 1.0, change=make_ideal)


def test_the_load_is_the_torque_less_friction(rough: Motor) -> None:
    """At 300 r/min friction takes 0.4 N m in the direction of turning; the load rises in 0.5 s."""
    s = constant(rough, RPM, TAU, 1.0)
    assert s.omega_0 == pytest.approx(RPM * np.pi / 30.0)
    assert (s.omega == s.omega_0[:, None]).all()
    assert s.tau[:, 0].tolist() == [0.0, 0.0, 0.0] and (s.t[:, 1] == 0.1).all()
    assert s.tau[:, -1] == pytest.approx([6.6, 7.4, -4.8])
    assert s.tau_rate == pytest.approx(np.full_like(s.tau_rate, 28.0))


def test_the_current_makes_the_torque_that_is_asked_for(rough: Motor, settled: Steady) -> None:
    assert settled.held.all()
    assert settled.omega_m == pytest.approx(RPM * np.pi / 30.0, rel=5e-3)
    assert torque(rough, settled.i) == pytest.approx(TAU, abs=0.1)


def test_without_errors_of_sensors_the_drive_sees_what_there_is(settled: Steady) -> None:
    """Its torque current is that of the rotor's frame turned by the error of the angle."""
    assert np.abs(settled.err).max() < np.radians(3.0)
    assert settled.err_std.max() < np.radians(1.0)
    i_d, i_q = settled.i.T
    seen = i_q * np.cos(settled.err) + i_d * np.sin(settled.err)
    assert settled.i_q_hat == pytest.approx(seen, abs=0.05)


def test_injection_alone_is_off_by_the_cross_angle(rough: Motor) -> None:
    """Without compensation; the observer beside it is not, and the error hardly moves."""
    design = DriveDesign(estimator="smo", cross="none")
    out = steady(rough, design, 150.0, [6.0, -6.0], 1.0, change=make_ideal)
    wanted = cross_angle(rough, out.i)
    assert np.abs(wanted).min() > np.radians(5.0)
    assert out.err_hfi == pytest.approx(wanted, abs=np.radians(0.5))
    assert out.err == pytest.approx(out.err_hfi, abs=1e-3)
    assert np.abs(out.err_smo - out.err_hfi).max() > np.radians(2.0)
    assert out.err_std.max() < np.radians(0.1)
    i_d, i_q = out.i.T
    seen = i_q * np.cos(out.err) + i_d * np.sin(out.err)
    assert out.i_q_hat == pytest.approx(seen, abs=0.01)
    assert np.abs(out.i_q_hat - i_q).min() > 0.05


def test_more_torque_than_the_current_limit_makes_is_not_held(rough: Motor) -> None:
    limit = replace(rough, i_max=rough.i_rated)
    out = steady(limit, DriveDesign(), 300.0, [5.0, 25.0], 1.0, settle=1.0, window=0.1)
    assert out.held.tolist() == [True, False]

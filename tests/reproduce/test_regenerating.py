"""The least torque current at which the observer's PLL stays damped, and what moves it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.steady import make_ideal, steady
from sensorless.machine.motor import Motor, Saturation

PUBLISHED = DriveDesign(
    estimator="smo",
    L_q_table=False,
    L_q_bias=1.0,
    mtpa=False,
    cross="none",
    speed_hz=1.0,
    smo_cross_hz=math.inf,
)


@pytest.mark.parametrize(("rpm", "hertz"), [(350, 20), (350, 30), (350, 50), (600, 30), (600, 50)])
def test_regenerating_bound_and_its_cure(motor: Motor, rpm: float, hertz: float) -> None:
    """Lost beyond i_q = -(2 zeta / w_n) E / (L_q - L_d), held before, each by 15 %.

    With a low-pass on the speed in the cross term it holds beyond the bound, too.
    """
    linear = replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))
    E = motor.rpm_to_electrical(rpm) * motor.psi_f
    bound = math.sqrt(2.0) / (2.0 * math.pi * hertz) * E / (motor.L_q - motor.L_d)
    tau = -1.5 * motor.n_p * motor.psi_f * bound * np.array([0.85, 1.15])
    design = replace(PUBLISHED, smo_pll_hz=hertz)
    plain = steady(linear, design, rpm, tau, 0.0, settle=3.5, change=make_ideal)
    assert plain.held.tolist() == [True, False]
    cured = replace(design, smo_cross_hz=20.0)
    assert steady(linear, cured, rpm, tau, 0.0, settle=3.5, change=make_ideal).held.all()

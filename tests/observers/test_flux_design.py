"""The flux observer's gains against the formulas and the numbers of its page."""

import math
from dataclasses import replace

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from sensorless.observers.flux_design import standstill_rate

FLUX = DriveDesign(estimator="flux")


@pytest.mark.parametrize(
    ("name", "k"), [("paper", 62), ("ipmsm_2200w", 114), ("pmsyrm_5600w", 312)]
)
def test_injection_holds_the_flux_as_the_page_says(name: str, k: int) -> None:
    """Three quarters of the dead time's drift, at a quarter of the weight, lead by 15 degrees."""
    motor = Motor.load(name)
    found = float(control_record(motor, FLUX)["flux"]["k_turn"]) / motor.T_s
    assert found == pytest.approx(k, rel=0.01)
    drift = motor.u_dc * motor.dead_time / motor.T_s / motor.psi_f
    assert math.degrees(0.75 * drift / (0.25 * found)) == pytest.approx(15.0, rel=1e-5)


def test_the_correction_at_rest_is_bounded_by_resistance_and_speed() -> None:
    """R_s (L_d + L_q) / (2 L_d L_q), from 3 to 10 % of rated electrical speed."""
    motor = Motor.load("ipmsm_2200w")
    for share, wanted in ((0.01, 0.03), (0.06, 0.06), (0.2, 0.1)):
        R_s = 2.0 * share * motor.omega_rated / (1.0 / motor.L_d + 1.0 / motor.L_q)
        found = standstill_rate(replace(motor, R_s=R_s))
        assert found == pytest.approx(wanted * motor.omega_rated)

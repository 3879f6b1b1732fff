"""How the axes of the current control are decoupled: by the current, or by its reference."""

import numpy as np
import pytest

from sensorless.design import control
from sensorless.design.control import (
    braking_current,
    half_load_inductance,
    reference_share,
    stiffening,
    weakening,
)
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record, designed
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import Scores, score
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy

FAST = member(5, 11)
"""20 PWM periods a turn at rated speed."""


def test_shipped_machines_decouple_by_the_measured_current() -> None:
    for path in MOTORS.glob("*.toml"):
        assert reference_share(Motor.load(path.stem)) == 0.0


def test_iron_without_saturation_is_no_stiffer() -> None:
    assert stiffening(Motor.load("ipmsm_2200w")) == pytest.approx(1.0, abs=1e-6)
    assert stiffening(Motor.load("pmsyrm_5600w")) > 2.0


def test_the_share_rises_with_turn_and_stiffness() -> None:
    assert reference_share(FAST) == 1.0
    part = member(8101, 8)
    turn = stiffening(part) * part.omega_rated * part.T_s
    assert reference_share(part) == pytest.approx((turn - 0.18) / 0.04)
    assert float(control_record(part, DriveDesign())["control"]["by_reference"]) == pytest.approx(
        reference_share(part)
    )


@pytest.mark.parametrize("name", ["pmsyrm_5600w", "pmsrm_15kw", "formula_wheel"])
def test_a_generator_short_of_voltage_keeps_the_current_that_takes_least(name: str) -> None:
    """|u| at rated speed over the braking current, on a grid; but a tenth of the limit at least."""
    motor = Motor.load(name)
    i_d, w, L_q = -0.9 * motor.i_max, motor.omega_rated, half_load_inductance(motor)
    i_q = np.linspace(0.0, motor.i_max, 20001)
    u_d = motor.R_s * i_d + w * L_q * i_q
    u_q = w * (motor.psi_f + motor.L_d * i_d) - motor.R_s * i_q
    least = float(i_q[np.argmin(np.hypot(u_d, u_q))])
    wanted = max(least, 0.1 * motor.i_max)
    assert braking_current(motor, i_d) == pytest.approx(wanted, rel=1e-3)


def test_field_weakening_is_faster_than_the_speed_loop_and_slower_than_the_current_s() -> None:
    """Five times the one, at most a fifth of the other [rad/s]."""
    assert weakening(1.0, 50.0) == pytest.approx(2.0 * np.pi * 5.0)
    assert weakening(4.0, 50.0) == pytest.approx(2.0 * np.pi * 10.0)


def test_by_the_measured_current_a_coarse_drive_swings(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 20 periods a turn: up to the current limit; by its reference one of six, for 0.2 s."""

    def run() -> Scores:
        designed.cache_clear()
        rows = SuiteRows("stress-1", FAST, 7701, 512).draw()[np.array([7, 14, 41, 58, 87, 101])]
        return score(make_policy("eq25", FAST), rows, SimFactory(FAST, DriveDesign()))

    own = run()
    monkeypatch.setattr(control, "reference_share", lambda motor: 0.0)
    measured = run()
    designed.cache_clear()
    assert np.all(measured.lost != 0)
    assert np.all(own.lost == 0)
    assert np.sum(own.metrics["torque_ripple_rms"] > 0.02) <= 1

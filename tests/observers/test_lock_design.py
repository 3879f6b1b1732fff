"""Numbers of the tests of lost lock on every shipped machine."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.decision import RUNNING, decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.evaluation import lock as judged
from sensorless.evaluation.metrics.held import BAND_PCT
from sensorless.machine.magnetics import mtpa
from sensorless.machine.motor import MOTORS, Motor
from sensorless.machine.saliency import principal
from sensorless.observers.hfi_design import hf_current
from sensorless.observers.lock_design import (
    ACTIONS,
    EVERY,
    answer_bounds,
    most_answer,
    settled,
    stall_time,
)
from sensorless.observers.tracking import rated_acceleration


@pytest.mark.parametrize("T_s", [5e-5, 2e-4, 8e-4, 1e-3])
def test_it_takes_two_failed_tests_to_raise_an_alarm(T_s: float) -> None:
    motor = replace(Motor.load("pmsyrm_5600w"), T_s=T_s)
    assert 2 <= control_record(motor, DriveDesign())["lock"]["n_alarm"] <= 12


def test_a_large_dead_time_leaves_little_of_the_answer() -> None:
    """As little as the file's own dead time leaves, and something in any case."""
    motor = Motor.load("formula_wheel")
    times = [x * motor.dead_time for x in (0.1, 1.0, 9.0)]
    bounds = [answer_bounds(replace(motor, dead_time=x)) for x in times]
    for part in ("answer", "rest"):
        assert bounds[0][part] > bounds[1][part] > bounds[2][part] > 0.0
    assert bounds[1]["rest"] < 0.5 * bounds[1]["answer"]


def test_the_bound_above_knows_the_iron_loss_of_the_file() -> None:
    """A conductance across the EMF at rated speed: p = 3/2 g (w psi_f)^2."""
    motor = Motor.load("ipmsm_2200w")
    loss = 0.1 * motor.tau_rated * motor.omega_rated / motor.n_p
    most = [most_answer(replace(motor, p_iron=x * loss)) for x in (1.0, 2.0)]
    drawn = motor.u_inj * loss / (1.5 * (motor.omega_rated * motor.psi_f) ** 2)
    assert most[1] - most[0] == pytest.approx(drawn, rel=1e-5)


def test_transistors_and_diodes_take_their_voltage_from_the_emf() -> None:
    """Three quarters of half a transistor's and half a diode's, of the file or usual ones."""
    motor, hub = Motor.load("paper"), Motor.load("ebike_hub")

    def floor(motor: Motor, **changed: Any) -> float:
        record = control_record(replace(motor, **changed), DriveDesign())
        return float(record["lock"]["e_floor"])

    more = floor(motor, u_transistor=2.0, u_diode=3.0) - floor(motor, u_transistor=1.0, u_diode=2.0)
    assert more == pytest.approx(0.75, rel=1e-4)
    usual = floor(motor, u_transistor=0.95, u_diode=0.8)
    assert floor(motor) == pytest.approx(usual, rel=1e-6)
    assert floor(hub, u_transistor=1.0) - floor(hub) == pytest.approx(0.375, rel=1e-4)


def test_grace_waits_for_field_weakening_where_the_emf_needs_it() -> None:
    """One of its time constants more if the EMF is beyond the usable voltage of a low link."""
    motor = Motor.load("ipmsm_2200w")
    limit = (
        motor.omega_rated * motor.psi_f * math.sqrt(3.0) / (0.88 * 0.97)
    )  # u_dc at which it may be
    short, enough = (settled(replace(motor, u_dc=x * limit), 800.0, 50.0) for x in (0.99, 1.01))
    assert enough == pytest.approx(4.0 * (4e-3 + 1.0 / 800.0))
    assert short - enough == pytest.approx(1.0 / 50.0)


def test_an_evaluation_keeps_step_with_decisions() -> None:
    assert EVERY == RUNNING
    assert judged.BAND == pytest.approx(0.01 * BAND_PCT)


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_limits_lie_between_noise_and_what_can_be_measured(name: str) -> None:
    motor = Motor.load(name)
    lock = control_record(motor, DriveDesign(estimator="smo"))["lock"]
    assert lock["n"] == decision_periods(motor)
    assert lock["action"] in ACTIONS.values()
    assert 0.0 < lock["e_floor"] < 0.5 * motor.omega_rated * motor.psi_f
    half_a_turn = math.pi / 0.02  # within 20 ms
    assert 30.0 < lock["jump"] < half_a_turn + 0.02 * rated_acceleration(motor)
    assert 0.1 * motor.i_rated < lock["i_off"] < 0.3 * motor.i_rated
    in_lock = hf_current(motor)
    assert in_lock * motor.L_d / motor.L_q < lock["answer"] < 0.9 * in_lock
    small = principal(motor, mtpa(motor)).T[0]
    assert lock["most"] > 1.1 * motor.u_inj * 0.5 * motor.T_s / np.min(small)
    out_of_reach = name in ("brusa_hsm1", "pmsyrm_5600w")  # much iron loss for their inductance
    assert (lock["most"] > motor.adc_range) == out_of_reach
    assert 0.0 < lock["rest"] <= lock["answer"]
    assert 0.0 < lock["i_loaded"] < motor.i_rated
    assert 0.5 * lock["e_floor"] < lock["e_least"] < lock["e_floor"]
    assert 0.05 * motor.L_d < lock["d_share"] / motor.omega_rated < 0.2 * motor.L_q
    assert 1 <= lock["n_alarm"] < lock["n_act"] < lock["n_calm"]


def test_a_fast_speed_loop_has_room_for_a_mean_of_the_current() -> None:
    """The reference moves 2 w i_rated in a second, so a mean of 1 ms is w ms i_rated behind it."""
    motor = Motor.load("paper")
    fast, slow = (
        control_record(motor, DriveDesign(speed_hz=hz, current_hz=20.0 * hz))["lock"]["i_off"]
        for hz in (25.0, 5.0)
    )
    step = decision_periods(motor) * motor.T_s
    assert slow == pytest.approx((0.1 + 0.1) * motor.i_rated, rel=1e-6)
    behind = 2.0 * math.pi * 25.0 * step
    assert fast == pytest.approx((0.05 + behind + 0.1) * motor.i_rated, rel=1e-6)


def test_a_steeper_reference_of_the_torque_current_may_lag_more() -> None:
    """A ramp of slope s lags s / (2 pi f) behind in a loop of bandwidth f, and half a mean."""
    motor = Motor.load("paper")
    slow, fast = (
        DriveDesign(current_hz=100.0, i_q_slew=1e4),
        DriveDesign(current_hz=100.0, i_q_slew=2e4),
    )
    i_off = [float(control_record(motor, d)["lock"]["i_off"]) for d in (slow, fast)]
    lag = 1e4 / (2.0 * math.pi * 100.0) + 0.5 * 1e4 * 1e-3
    assert i_off[1] - i_off[0] == pytest.approx(lag, rel=1e-3)


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w"])
def test_the_emf_may_miss_what_the_drive_does_not_know(name: str) -> None:
    """A speed off by 0.15 of rated, 3/4 of dead time and switches, and half of what R_s takes."""
    motor = Motor.load(name)
    lock = control_record(motor, DriveDesign())["lock"]
    switches = 0.25 * (0.7 + 1.2 + 0.6 + 1.0)  # IGBTs and diodes
    lost = motor.u_dc * motor.dead_time / motor.T_s + switches
    speed = 0.15 * motor.omega_rated * motor.psi_f
    drop = motor.R_s * motor.i_rated
    assert lock["e_floor"] == pytest.approx(speed + 0.75 * lost + 0.5 * drop, rel=1e-5)
    assert lock["R_warm"] == pytest.approx(0.5 * motor.R_s, rel=1e-5)
    late = 0.07 * motor.omega_rated * motor.psi_f + lost
    assert lock["e_late"] == pytest.approx(late, rel=1e-5)


@pytest.mark.parametrize(("start", "told"), [(0.1, 0.5), (10.0, 2.0), (1000.0, 60.0)])
def test_a_heavy_shaft_may_take_its_time_to_start(start: float, told: float) -> None:
    """Ten times the inertia to 2 % of the speed that rated torque reaches in ``start`` seconds."""
    motor = Motor.load("paper")
    speed = motor.omega_rated / motor.n_p
    assert stall_time(replace(motor, J=start * motor.tau_rated / speed)) == pytest.approx(told)

"""The L_q that the coupled observer takes: low, but where that swings or deviates."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record, designed
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import Scores, score
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers import drift_design
from sensorless.observers.q_inductance import lean, learned_share, rise_by_lean
from sensorless.policies.registry import make_policy

FAST = member(8101, 7)
"""24 PWM periods a turn at rated speed."""
LEANING = member(4104, 7)
"""At rated current L_q i_q is the auxiliary flux; injection is slow beside the hand-over."""


def scores(motor: Motor, suite: str, seed: int, which: list[int], design: DriveDesign) -> Scores:
    """Scenarios of a suite of 64 under Eq. 25."""
    rows = SuiteRows(suite, motor, seed, 64).draw()[np.array(which)]
    return score(make_policy("eq25", motor), rows, SimFactory(motor, design))


def test_shipped_machines_keep_the_low_inductance() -> None:
    for path in MOTORS.glob("*.toml"):
        motor = Motor.load(path.stem)
        assert derive(motor, DriveDesign()).coupled_L_q_bias == 0.85
        assert learned_share(motor) == 0.09


def test_it_rises_with_the_turn_in_a_period() -> None:
    assert FAST.omega_rated * FAST.T_s == pytest.approx(0.265, abs=0.01)
    assert derive(FAST, DriveDesign()).coupled_L_q_bias == 0.95
    slower = member(8101, 102)
    turn = slower.omega_rated * slower.T_s
    assert derive(slower, DriveDesign()).coupled_L_q_bias == 0.85 + 1.25 * (turn - 0.16)


def test_a_low_inductance_deviates_more_there() -> None:
    low, own = (
        scores(FAST, "stress-1", 4711, list(range(12)), design)
        for design in (DriveDesign(coupled_L_q_bias=0.85), DriveDesign())
    )
    assert not low.lost.any() and not own.lost.any()
    deviation = own.metrics["torque_dev_rms"].mean() / low.metrics["torque_dev_rms"].mean()
    assert deviation < 0.9


@pytest.mark.parametrize("name", ["brusa_hsm1", "ipmsm_2200w", "ebike_hub", "formula_wheel"])
def test_the_lean_of_a_machine_without_saturation(name: str) -> None:
    """Its best current has i_d = (psi_f - sqrt(psi_f^2 + 8 D^2 i^2)) / (4 D), D = L_q - L_d."""
    motor = Motor.load(name)
    diff, i = motor.L_q - motor.L_d, motor.i_rated
    i_d = (motor.psi_f - np.hypot(motor.psi_f, np.sqrt(8.0) * diff * i)) / (4.0 * diff)
    i_q = np.sqrt(i**2 - i_d**2)
    assert lean(motor) == pytest.approx(motor.L_q * i_q / (motor.psi_f - diff * i_d), rel=2e-3)


def test_the_rise_by_lean_is_bounded_and_takes_from_what_is_learned() -> None:
    assert rise_by_lean(LEANING) == 0.1
    assert derive(LEANING, DriveDesign()).coupled_L_q_bias == pytest.approx(0.95)
    assert learned_share(LEANING) == pytest.approx(0.03)
    part = member(7207, 58)
    assert 0.01 < rise_by_lean(part) < 0.09
    assert learned_share(part) == 0.09 - 0.6 * rise_by_lean(part)
    assert derive(part, DriveDesign()).coupled_L_q_bias == 0.85 + rise_by_lean(part)
    slow = replace(LEANING, n_rated_rpm=0.3 * LEANING.n_rated_rpm)
    assert rise_by_lean(slow) == 0.0, "injection is fast beside a slow hand-over"


def test_what_is_learned_reaches_the_drive() -> None:
    more = control_record(LEANING, DriveDesign())["coupled"]["drift"]
    low = control_record(LEANING, DriveDesign(coupled_L_q_bias=0.85))["coupled"]["drift"]
    assert more["ind_most"] == low["ind_most"], "bounded by the machine"
    assert more["ind_0"] == pytest.approx(-0.5 * more["ind_most"], rel=1e-5)
    assert low["ind_0"] == -low["ind_most"]


def test_a_low_inductance_loses_drives_there_and_this_one_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def run(design: DriveDesign) -> Scores:
        designed.cache_clear()
        return scores(LEANING, "stress-1", 4711, [5, 13, 20, 37, 54, 56], design)

    own = run(DriveDesign())
    monkeypatch.setattr(drift_design, "learned_share", lambda motor: 0.09)
    low = run(DriveDesign(coupled_L_q_bias=0.85))
    designed.cache_clear()
    assert (low.lost != 0).sum() >= 3
    assert not own.lost.any()
    assert np.all(own.lock["false_alarms"] == 0)

"""What the quick runs of a machine's check add to the verdict."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.evaluation import machine_check
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.machine_check import LOST, SUITES, QuickRun, dead_time_hint, judged
from sensorless.machine.motor import Motor, Saturation
from sensorless.policies.registry import make_policy
from sensorless.report.motor_check import RUNS, check, facts, rows, run_rows
from sensorless.suitability.finding import LIMIT, NO, NOTE


@pytest.mark.parametrize(
    ("lost", "not_held", "infeasible", "weights", "said"),
    [
        (0.0, 0.0, 0.0, [], ""),
        (0.02, 0.03, 0.0, [NOTE, NOTE], "loses 2%"),
        (0.0, 0.03, 0.0, [NOTE], "stays off its speed in 3% of unload"),
        (0.1, 0.0, 0.0, [LIMIT], "loses 10% of the feasible scenarios of unload"),
        (0.3, 0.0, 0.0, [NO], "loses 30%"),
        (0.1, 0.0, 0.2, [LIMIT, LIMIT], "fails 20% of unload"),
        (0.0, 0.62, 0.0, [LIMIT], "stays off its speed in 62% of unload: more inertia"),
        (0.03, 0.03, 0.0, [NOTE, LIMIT], "in 3% of unload (and loses 3%)"),
        (math.nan, math.nan, 1.0, [NO], "fails all of unload"),
    ],
)
def test_what_a_quick_run_finds(
    lost: float, not_held: float, infeasible: float, weights: list[str], said: str
) -> None:
    found = judged([QuickRun("unload", 100, lost, not_held, infeasible, 0.01)])
    assert [finding.weight for finding in found] == weights
    texts = " ".join(finding.text for finding in found)
    assert said in texts and "nan" not in texts


def test_suites_in_which_the_speed_is_not_held_are_told_once() -> None:
    runs = [QuickRun(suite, 100, 0.0, 0.1, 0.0, 0.01) for suite in ("stress", "braking")]
    (found,) = judged(runs)
    assert "in 10% of stress, 10% of braking: more inertia" in found.text


@pytest.mark.parametrize(("alarms", "weight"), [(0.02, NOTE), (0.3, LIMIT)])
def test_alarms_of_drives_that_hold_are_told(alarms: float, weight: str) -> None:
    (found,) = judged([QuickRun("hold", 100, 0.0, 0.0, 0.0, 0.01, alarms=alarms)])
    assert found.weight == weight and f"lost {100 * alarms:.0f} times in 100" in found.text


def test_a_control_that_swings_with_an_encoder_too_is_told() -> None:
    (found,) = judged([QuickRun("hold", 100, 0.0, 0.0, 0.0, 0.01, twin_swings=0.1)])
    assert found.weight == LIMIT and "with an encoder too" in found.text


def test_losses_that_the_drive_does_not_tell_are_told() -> None:
    (found,) = judged([QuickRun("hold", 100, 0.1, 0.0, 0.0, 0.01, told=0.25)])
    assert "of hold, and tells 25% of them in time" in found.text


@pytest.mark.parametrize("lost", [0.1, 0.9, 1.0])
def test_losses_with_a_wrong_file_ask_for_a_right_one(lost: float) -> None:
    (found,) = judged([QuickRun("mismatch", 100, lost, 0.0, 0.0, 0.01)])
    assert found.weight == LIMIT and "of mismatch: measure resistance" in found.text


def test_a_wrong_file_limits_whatever_it_makes_of_the_speed() -> None:
    """Not held, or failed by the sensored twin in every scenario: measure the motor."""
    for lost, not_held, infeasible in ((0.0, 0.1, 0.0), (math.nan, math.nan, 1.0)):
        (found,) = judged([QuickRun("mismatch", 100, lost, not_held, infeasible, 0.01)])
        assert found.weight == LIMIT and "of mismatch: measure resistance" in found.text


def test_a_machine_that_depends_on_its_file_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is fit as long as its file is right."""
    monkeypatch.setattr(machine_check, "SUITES", ("stress", "impact", "mismatch"))
    motor = member(501, 2)
    done = check(replace(motor, J=0.65 * motor.J), DriveDesign(), 100)
    lost = {run.suite: run.lost for run in done.runs}
    assert lost.pop("mismatch") > LOST[0] and max(lost.values()) <= 0.02
    texts = [finding.text for finding in done.examination.findings]
    assert any("of mismatch" in text and ": measure" in text for text in texts)


def test_loads_at_low_speed_and_a_wrong_file_are_run_too() -> None:
    done = check(Motor.load("paper"), DriveDesign(), 4)
    suites = [run.suite for run in done.runs]
    assert suites == list(SUITES) and {"braking", "reversal", "mismatch"} <= set(SUITES)
    found = {what: text for what, text, _ in rows(done)}
    for run, said, told in zip(done.runs, facts(done)["runs"], run_rows(done), strict=True):
        assert said["not_held"] == run.not_held == said["slipped"] == run.slipped == 0.0
        assert told[:5] == (f"4 {run.suite}", "0%", "0%", "0%", "0%")
        assert told[5] == f"{100.0 * run.torque_dev:.2f} %" and len(told) == len(RUNS)
    assert "dips the speed by some 10% of rated, for " in found["load step"]


def test_a_bare_servo_shaft_is_told_that_it_is_light() -> None:
    """From rest to rated speed in 5 ms: loads run ahead of the drive, which slips and is back."""
    servo = replace(
        Motor.load("paper"), n_p=5, R_s=1.1, L_d=3.2e-3, L_q=4.6e-3, psi_f=0.036, J=1.6e-5, B=1e-5,
        tau_rated=1.0, i_rated=3.6, n_rated_rpm=3000.0, u_dc=310.0, T_s=1e-4, u_inj=40.0, i_max=7.5,
        i_trip=15.0, dead_time=2.5e-6, adc_range=16.0,
        saturation=Saturation.linear(3.2e-3, 4.6e-3, 0.036),
    )  # fmt: skip
    done = check(servo, DriveDesign(), 50)
    (light,) = (f for f in done.examination.findings if f.field == "J")
    assert light.weight == NOTE and f"dips the speed by some {done.dip:.0%}" in light.text
    assert done.dip > 0.3
    run = done.runs[0]
    eq25 = {"eq25": make_policy("eq25", servo)}
    found = evaluate(servo, DriveDesign(), run.suite, 1, 50, eq25).policies["eq25"]["scenarios"]
    kept = np.array([cause is None for cause in found["lost_cause"]])
    slips = np.count_nonzero(kept & (np.array(found["angle_err_max_deg"]) > 60.0))
    assert 50.0 * run.slipped == pytest.approx(slips) and slips > 0
    told = [f for f in done.examination.findings if "slips and comes back in" in f.text]
    for f, r in zip(told, (r for r in done.runs if r.slipped), strict=True):
        assert f"scenarios of {r.suite} (" in f.text
        assert f.weight == (LIMIT if r.slipped > 0.05 else NOTE)


@pytest.mark.parametrize(("slipped", "weight"), [(0.01, NOTE), (0.06, LIMIT)])
def test_slips_are_told(slipped: float, weight: str) -> None:
    (found,) = judged([QuickRun("stress", 100, 0.0, 0.0, 0.0, 0.01, slipped=slipped)])
    assert found.weight == weight and f"in {slipped:.0%} of the feasible" in found.text
    assert "measure" not in found.text


@pytest.mark.parametrize(
    ("name", "said"), [("paper", "from any angle"), ("ipmsm_2200w", "from a known angle only")]
)
def test_it_says_whether_the_drive_finds_the_rotor(name: str, said: str) -> None:
    found = {what: text for what, text, _ in rows(check(Motor.load(name), DriveDesign(), 0))}
    assert said in found["start"]


def test_trips_at_a_right_angle_ask_for_a_higher_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not those of drives whose angle was lost first, nor those that an encoder does not save."""
    monkeypatch.setattr(machine_check, "SUITES", ("stress", "braking"))
    brusa = Motor.load("brusa_hsm1")
    close = replace(brusa, i_trip=0.95 * brusa.i_max)
    (run,) = (r for r in check(close, DriveDesign(), 24).runs if r.suite == "braking")
    assert run.lost > LOST[0] and run.tripped > 0.5
    assert any("a higher i_trip" in finding.text for finding in judged([run]))
    lost_first = check(member(7207, 29), DriveDesign(coupled_L_q_bias=1.2), 16).runs[0]
    assert lost_first.lost > LOST[0] and lost_first.tripped < 0.2
    assert "i_trip" not in judged([lost_first])[0].text


def test_too_little_injection_for_the_switches_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine of a 158 V link that loses none of ``stress-1``, where switches take nothing."""
    monkeypatch.setattr(machine_check, "SUITES", ("stress",))
    weak = member(1000502, 54)
    done = check(weak, DriveDesign(), 24)
    assert done.runs[0].lost > LOST[1] and done.examination.verdict.word == "no"
    assert any("3.05 V, which dead_time" in f.text for f in done.examination.findings)
    suggested = done.examination.suggested
    assert suggested is not None
    enough = check(replace(weak, u_inj=suggested["u_inj"]), DriveDesign(), 24)
    assert enough.runs[0].lost <= LOST[0]


def test_dead_time_is_named_where_it_takes_half_of_what_tells_the_axes() -> None:
    motor = Motor.load("ipmsm_2200w")
    tells = motor.u_inj * (1.0 - motor.L_d / motor.L_q)
    per_V = motor.T_s / motor.u_dc
    assert dead_time_hint(replace(motor, dead_time=0.45 * tells * per_V)) == ""
    hint = dead_time_hint(replace(motor, dead_time=0.55 * tells * per_V))
    assert f"takes {0.55 * tells:.3g} V of the {tells:.3g} V" in hint

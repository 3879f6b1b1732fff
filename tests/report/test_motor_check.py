"""What the quick runs of a machine's check add to the verdict."""

import math
from dataclasses import replace

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.evaluation.machine_check import LOST, QuickRun, judged
from sensorless.machine.motor import Motor
from sensorless.report.motor_check import check, facts, rows
from sensorless.suitability.finding import LIMIT, NO


@pytest.mark.parametrize(
    ("lost", "not_held", "infeasible", "weights", "said"),
    [
        (0.0, 0.0, 0.0, [], ""),
        (0.02, 0.03, 0.0, [], ""),
        (0.1, 0.0, 0.0, [LIMIT], "loses 10% of the feasible scenarios of unload"),
        (0.3, 0.0, 0.0, [NO], "loses 30%"),
        (0.1, 0.0, 0.2, [LIMIT, LIMIT], "fails 20% of unload"),
        (0.0, 0.62, 0.0, [LIMIT], "stays off its speed in 62% of unload: more inertia"),
        (0.03, 0.03, 0.0, [LIMIT], "in 3% of unload"),
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


def test_loads_at_low_speed_are_run_too() -> None:
    done = check(Motor.load("paper"), DriveDesign(), 4)
    assert [run.suite for run in done.runs] == ["stress", "unload", "braking"]
    found = {what: text for what, text, _ in rows(done)}
    for run, said in zip(done.runs, facts(done)["runs"], strict=True):
        assert said["not_held"] == run.not_held == 0.0
        assert "speed not held 0%" in found[f"quick run, 4 of suite {run.suite}"]


@pytest.mark.parametrize(
    ("name", "said"), [("paper", "from any angle"), ("ipmsm_2200w", "from a known angle only")]
)
def test_it_says_whether_the_drive_finds_the_rotor(name: str, said: str) -> None:
    found = {what: text for what, text, _ in rows(check(Motor.load(name), DriveDesign(), 0))}
    assert said in found["start"]


def test_trips_ask_for_a_shorter_period() -> None:
    """A machine of 21 PWM periods a turn with too high an L_q: by the current limit."""
    coarse = member(7207, 29)
    run, *_ = check(coarse, DriveDesign(coupled_L_q_bias=1.2), 16).runs
    assert run.lost > LOST[0] and run.tripped == 1.0
    assert any("shorter T_s" in finding.text for finding in judged([run]))
    assert "T_s" not in judged([QuickRun("stress-1", 100, 0.1, 0.0, 0.0, 0.01, 0.2)])[0].text


def test_too_little_injection_for_the_switches_is_told() -> None:
    """A machine of a 158 V link that loses none of ``stress-1``, where switches take nothing."""
    weak = member(1000502, 54)
    done = check(weak, DriveDesign(), 50)
    assert done.runs[0].lost > LOST[1] and done.examination.verdict.word == "no"
    assert any("3.05 V, which dead_time" in f.text for f in done.examination.findings)
    suggested = done.examination.suggested
    assert suggested is not None
    enough = check(replace(weak, u_inj=suggested["u_inj"]), DriveDesign(), 50)
    assert enough.runs[0].lost <= LOST[0]

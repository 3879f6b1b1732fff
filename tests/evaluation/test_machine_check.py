"""What a machine's check counts in a quick run, and how much it weighs: made-up evaluations."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation import machine_check
from sensorless.evaluation.machine_check import Check, QuickRun, check, judged, swings_idle
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.suitability.finding import LIMIT, NO, NOTE

PAPER, DESIGN = Motor.load("paper"), DriveDesign()
NONE = QuickRun("hold", 100, 0.0, 0.0, 0.0, 0.01)
"""Nothing to say of it."""


def weights(**found: Any) -> list[str]:
    return [finding.weight for finding in judged([replace(NONE, **found)])]


@pytest.mark.parametrize(
    ("lost", "weight"), [(0.04, NOTE), (0.06, LIMIT), (0.19, LIMIT), (0.21, NO)]
)
def test_more_than_5_percent_lost_limits_and_more_than_20_refuse(lost: float, weight: str) -> None:
    assert weights(lost=lost) == [weight]
    assert weights(lost=lost, suite="mismatch") == [NOTE if weight == NOTE else LIMIT]


@pytest.mark.parametrize("what", ["not_held", "slipped", "alarms", "twin_swings"])
def test_what_does_not_lose_limits_from_5_percent_on(what: str) -> None:
    assert weights(**{what: 0.04}) == [NOTE]
    assert weights(**{what: 0.06}) == [LIMIT]


def test_lost_and_not_held_add_up() -> None:
    """Each is below a limit, both together are not."""
    assert weights(lost=0.03, not_held=0.03) == [NOTE, LIMIT]


def test_more_than_5_percent_that_an_encoder_fails_limits() -> None:
    assert weights(infeasible=0.04) == []
    assert weights(infeasible=0.06) == [LIMIT]


@pytest.mark.parametrize(
    ("swing", "found"), [(0.019, []), (0.021, [NOTE]), (0.049, [NOTE]), (0.051, [LIMIT])]
)
def test_a_swing_without_load_is_noted_from_2_percent_and_limits_from_5(
    swing: float, found: list[str]
) -> None:
    assert [f.weight for f in swings_idle(swing, 0.5, "Eq. 25")] == found


def checked(
    monkeypatch: pytest.MonkeyPatch,
    causes: list[str | None],
    angle: list[float],
    swing: list[float],
    motor: Motor = PAPER,
    design: DriveDesign = DESIGN,
    **lock: int,
) -> Check:
    """A check whose only evaluation found this, and an eighth of it not held."""
    n = len(causes)
    found = {
        "lost_rate": 0.25,
        "not_held_rate": 0.125,
        "infeasible_rate": sum("twin" in (cause or "") for cause in causes) / n,
        "torque_dev_rms": 0.02,
        "scenarios": {
            "lost_cause": causes,
            "angle_err_max_deg": angle,
            "twin_swing_pct": swing,
        },
        "lock_counts": {"watched": 0, "detected": 0, "false_alarms": 0, "near_losses": 0} | lock,
    }
    monkeypatch.setattr(machine_check, "SUITES", ("hold",))
    monkeypatch.setattr(machine_check, "idle_swing", lambda *of: (0.0, 0.5))
    monkeypatch.setattr(
        machine_check, "evaluate", lambda *of: SimpleNamespace(policies={"Eq. 25": found})
    )
    return check(motor, design, make_policy("eq25", motor), "Eq. 25", n)


def test_shares_are_those_of_the_scenarios_that_an_encoder_can_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ten scenarios, two of which the sensored twin fails: every share is of eight."""
    causes = [*[None] * 5, "current", "current", "angle", "twin", "current+twin"]
    angle = [70.0, 70.0, 10.0, 10.0, 10.0, 10.0, 90.0, 90.0, 90.0, 10.0]
    swing = [3.0] + [1.0] * 7 + [3.0, 3.0]
    (run,) = checked(monkeypatch, causes, angle, swing, false_alarms=7, near_losses=3).runs
    assert run.infeasible == pytest.approx(0.2)
    assert run.slipped == pytest.approx(2 / 8)
    assert run.twin_swings == pytest.approx(1 / 8)
    assert run.alarms == pytest.approx((7 - 3) / 8)
    assert run.tripped == pytest.approx(1 / 3), "of three lost, one by current at a right angle"
    assert (run.lost, run.not_held, run.torque_dev) == (0.25, 0.125, 0.02)


def test_a_loss_that_is_told_late_is_not_told_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    causes: list[str | None] = ["angle"] * 4
    (run,) = checked(monkeypatch, causes, [90.0] * 4, [0.0] * 4, watched=4, detected=3).runs
    assert run.told == pytest.approx(0.75)
    (run,) = checked(monkeypatch, causes, [90.0] * 4, [0.0] * 4).runs
    assert run.told == 1.0, "none was watched"


def dipping(dip: float) -> DriveDesign:
    """Design whose critically damped speed loop of w dips by tau / (e w J) after a rated load."""
    w = PAPER.tau_rated / (math.e * PAPER.J * dip * PAPER.omega_rated / PAPER.n_p)
    return DriveDesign(speed_hz=w / (2.0 * math.pi))


@pytest.mark.parametrize(("dip", "noted"), [(0.29, False), (0.31, True)])
def test_a_shaft_that_dips_by_30_percent_is_noted(dip: float, noted: bool) -> None:
    done = check(PAPER, dipping(dip), make_policy("eq25", PAPER), "Eq. 25", 0)
    assert done.dip == pytest.approx(dip)
    found = [f.weight for f in done.examination.findings if f.field == "J"]
    assert found == ([NOTE] if noted else [])


@pytest.mark.parametrize(
    ("dip", "i_max", "helps"), [(0.2, 1.5, True), (0.09, 1.5, False), (0.2, 0.9, False)]
)
def test_inertia_is_asked_for_where_it_helps(
    dip: float, i_max: float, helps: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a lighter shaft than designed for; where the current is short, more is longer at it."""
    motor = replace(PAPER, i_max=i_max * PAPER.i_rated)
    done = checked(monkeypatch, [None] * 8, [5.0] * 8, [0.0] * 8, motor, dipping(dip))
    (said,) = (f.text for f in done.examination.findings if "off its speed" in f.text)
    assert ("more inertia on the shaft helps" in said) == helps

"""What a run records of a drive that runs away, and how that is summed up."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.words import fig9, plan_from
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.rollout import CAUSES
from sensorless.evaluation.trace import TESTS, Trace, cut_short, lost_cause, outcome, trace
from sensorless.evaluation.trace_summary import plateaus
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import NO_SETTINGS, Signals


def test_a_run_ends_where_numbers_overflow() -> None:
    """Far beyond rated speed the current control no longer holds even with an encoder."""
    motor = Motor.load("paper")
    plan = plan_from(fig9(motor), "0:-33", None, 8.0, motor, 1)
    t = trace(make_policy("eq25", motor), plan, motor, DriveDesign(), go_on=True)
    n = len(t["t"])
    assert 0.5 < t["t"][-1] < 7.9
    assert all(len(column) == n for column in t.values())
    assert all(np.isfinite(column).all() for column in t.values())
    assert outcome(t).startswith("not feasible: the drive with an encoder trips or runs away")
    assert str(cut_short(t, 8.0)).startswith(f"the run ends at {t['t'][-1]:.3f} of 8 s")


LIGHT = replace(Motor.load("paper"), J=0.002)
"""The paper's machine with a tenth of its inertia."""
BEYOND = plan_from("0:100", "0:33", None, 0.6, LIGHT, 0)
"""A load that turns it back: the drive is lost within 40 ms, its twin 40 ms later."""


@pytest.fixture(scope="module")
def overloaded() -> Trace:
    return trace(make_policy("eq25", LIGHT), BEYOND, LIGHT, DriveDesign(), go_on=True)


def test_what_the_twin_cannot_do_is_not_feasible_whoever_trips_first(overloaded: Trace) -> None:
    """As in an evaluation."""
    judged = score(make_policy("eq25", LIGHT), BEYOND, SimFactory(LIGHT, DriveDesign()))
    verdict = overloaded["t"][overloaded["judged"]][0]
    assert verdict < overloaded["twin_fails"][0] < verdict + 0.1, "lost first"
    assert outcome(overloaded).startswith("not feasible: the drive with an encoder")
    assert judged.lost[0] & CAUSES["twin"]
    assert lost_cause(overloaded) == "+".join(
        c for c, bit in CAUSES.items() if judged.lost[0] & bit
    )


def test_a_summary_counts_up_to_the_verdict_alone(overloaded: Trace) -> None:
    (row,) = plateaus(overloaded)
    before = ~overloaded["judged"]
    assert np.abs(overloaded["omega_m"]).max() > 10.0 * np.abs(overloaded["omega_m"][before]).max()
    error = np.rad2deg(np.abs(overloaded["theta_e_err"][before]).max())
    assert row["angle_err_max_deg"] == pytest.approx(error)
    assert row["overshoot_pct"] < 1e4


def test_a_load_step_is_no_part_of_the_step_of_the_speed() -> None:
    """It would count as a late settling, and its dip and rise as overshoot."""
    motor = Motor.load("paper")
    rows = []
    for load in ("0:0", "0.6:14", "0.03:14"):
        plan = plan_from("0:100", load, None, 1.0, motor, 0)
        rows += plateaus(trace(make_policy("eq25", motor), plan, motor, DriveDesign()))
    calm, loaded, early = rows
    for name in ("settled_s", "overshoot_pct"):
        assert loaded[name] == pytest.approx(calm[name]) and np.isfinite(calm[name])
        assert np.isnan(early[name]), "no time to tell"
    assert loaded["angle_err_max_deg"] > calm["angle_err_max_deg"]


def test_errors_are_of_half_a_turn_at_most(overloaded: Trace) -> None:
    for name in ("theta_e_err", "theta_e_err_hfi", "theta_e_err_smo"):
        assert np.abs(overloaded[name]).max() <= np.pi + 1e-6


def test_a_narrow_escape_is_said() -> None:
    """Time beyond 60 degrees, less than the judge's 10 ms, and the drive's own alarm."""
    motor = Motor.load("paper")
    plan = plan_from("0:100", "0:0", None, 0.1, motor, 0)
    t = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    assert outcome(t) == "kept lock"
    t["theta_e_err"][100:120] = -np.deg2rad([59.0] * 5 + [61.0] * 15)
    assert outcome(t) == "kept lock, but the angle error passed 60° for 3 ms in all"
    glimpse = {name: x[110:111] for name, x in t.items()}
    assert outcome(glimpse).endswith("passed 60° for 0 ms in all")
    t["alarm"][110:200], t["reason"][110:] = True, TESTS["EMF"] | TESTS["current"]
    assert outcome(t).endswith("3 ms in all and its own alarm came at 0.022 s (EMF, current)")
    t["starting"][:150] = 1.0
    assert outcome(t) == "kept lock, but its own alarm came at 0.022 s (EMF, current)"
    t["alarm"][:] = False
    assert outcome(t) == "kept lock"


@pytest.mark.parametrize(
    ("ms", "said"), [(0.2, "0.2"), (9.6, "9.6"), (12.4, "12"), (99.8, "100"), (140.0, "140")]
)
def test_the_time_beyond_the_limit_is_told_in_plain_digits(ms: float, said: str) -> None:
    motor = Motor.load("paper")
    plan = plan_from("0:100", "0:0", None, 0.2, motor, 0)
    t = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    t["theta_e_err"][: round(1e-3 * ms / motor.T_s)] = np.deg2rad(61.0)
    assert outcome(t) == f"kept lock, but the angle error passed 60° for {said} ms in all"


def test_an_alarm_long_before_the_verdict_is_not_of_it() -> None:
    """It ended half a second before."""
    t = np.arange(1000) * 1e-3
    never = np.zeros(1000, dtype=bool)
    run = {"t": t, "judged": t > 0.8, "recovering": never, "lost": np.full(1000, CAUSES["angle"])}
    assert outcome({**run, "alarm": (t > 0.2) & (t < 0.3)}) == "lost (angle), unnoticed"
    late = outcome({**run, "alarm": (t > 0.7505) & (t < 0.79)})
    assert late == "lost (angle), alarm 49 ms before the verdict"


def test_the_tests_that_failed_are_recorded() -> None:
    motor = Motor.load("paper")
    for degrees, gone in ((70.0, False), (100.0, True)):
        plan = plan_from("0:600", "0:0", None, 0.3, motor, 0, theta_err=degrees)
        t = trace(make_policy("eq25", motor), plan, motor, DriveDesign(), go_on=True)
        assert outcome(t).startswith("lost (angle)" if gone else "kept lock, but the angle")
        assert t["alarm"].any() == bool(t["reason"][-1]) == gone


class Fixed:
    """Always answers the same."""

    name, sensored, settings = "fixed", False, NO_SETTINGS

    def __init__(self, weights: object) -> None:
        self.weights = weights

    def reset(self, n: int) -> None:
        pass

    def act(self, obs: Signals) -> Any:
        return self.weights


@pytest.mark.parametrize(
    ("weights", "said"),
    [([-1.0], "-1; give 0 to 1"), ([2.0], "2; give 0 to 1"), ([np.nan], "nan; give 0 to 1"),
     ([], "shape (0,) for 1 drives; give (1,)"), ([[1.0]], "shape (1, 1) for 1 drives"),
     (None, "shape () for 1 drives"), (1.0, "shape () for 1 drives")],
)  # fmt: skip
def test_a_wrong_weight_is_no_trace(weights: object, said: str) -> None:
    """The core would take 1 in its place: evaluate refuses it, too."""
    motor = Motor.load("paper")
    case = plan_from("0:40", "0:0", None, 0.1, motor, 1)
    with pytest.raises(UserError, match=f"^policy fixed: act gave {re.escape(said)}"):
        trace(Fixed(weights), case, motor, DriveDesign())


def test_ripple_is_about_the_mean_of_20_ms_and_without_injection(overloaded: Trace) -> None:
    """Closed form: sine, sine, and a square wave of the period that a mean of two takes away."""
    motor = Motor.load("paper")
    plan = plan_from("0:100", "0:0", None, 0.5, motor, 0)
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    t, T_s = run["t"], motor.T_s
    slow, fast = 3.0 * np.sin(2.0 * np.pi * 1.0 * t), 2.0 * np.sin(2.0 * np.pi * 200.0 * t)
    injected = 5.0 * np.where(np.arange(len(t)) % 2, 1.0, -1.0)
    (row,) = plateaus({**run, "tau": 7.0 + slow + fast + injected})
    assert row["torque_ripple_nm"] == pytest.approx(
        2.0 / np.sqrt(2.0) * np.cos(np.pi * 200.0 * T_s), rel=0.01
    )
    assert plateaus(overloaded)[0]["torque_ripple_nm"] >= 0.0

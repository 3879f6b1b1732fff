"""What a run, a plan or a policy that went wrong is told by."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.envs.scenarios.words import plan_from
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.trace import outcome, trace
from sensorless.evaluation.trace_summary import plateaus
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.units import RAD_S_TO_RPM

MOTOR = Motor.load("paper")


@pytest.mark.parametrize(("load", "missed"), [("0:0", False), ("0:0,1.2:33", True)])
def test_a_speed_that_a_load_drags_away_is_told(load: str, missed: bool) -> None:
    plan = plan_from("0:600", load, None, 1.5, MOTOR, 0)
    told = outcome(trace(make_policy("eq25", MOTOR), plan, MOTOR, DriveDesign(), go_on=True))
    assert ("of 600 r/min at the end, with an encoder" in told) == missed, told


def test_a_speed_that_swings_to_the_end_never_settles() -> None:
    plan = plan_from("0:600", "0:0", None, 1.5, MOTOR, 0)
    t = trace(make_policy("eq25", MOTOR), plan, MOTOR, DriveDesign())
    assert plateaus(t)[0]["settled_s"] < 1.0
    t["omega_m"] = t["omega_m"] * (1.0 + 0.05 * np.sin(2.0 * np.pi * 7.0 * t["t"]))
    assert np.isnan(plateaus(t)[0]["settled_s"])


@pytest.mark.parametrize(
    ("plan", "why"),
    [("200", "a time of 0 s or more"), ("-1:5", "a time of 0 s or more"),
     ("0:nan", "a time of 0 s or more"), ("1:5,0:2", "do not rise")],
)  # fmt: skip
def test_a_plan_is_refused_with_its_reason(plan: str, why: str) -> None:
    with pytest.raises(UserError, match=why):
        plan_from(plan, "0:0", None, 1.0, MOTOR, 0)


def test_a_plan_beyond_the_end_is_noted() -> None:
    for plan, noted in (("0:200,5:300", True), ("0:200", False)):
        done = CliRunner().invoke(app, ["simulate", "--speed", plan, "--duration", "0.05"])
        assert done.exit_code == 0
        assert ("the plan goes on to 5 s, but the run ends at 0.05 s" in done.output) == noted


def test_a_speed_that_the_drive_does_not_follow_is_noted() -> None:
    """With the bound of docs/protection.md: speed_bound times rated, less a load's dip."""
    most = float(control_record(MOTOR, DriveDesign())["guard"]["omega"]) * RAD_S_TO_RPM / MOTOR.n_p
    assert 2.0 * MOTOR.n_rated_rpm < most < 2.5 * MOTOR.n_rated_rpm
    for share, noted in ((0.99, False), (1.01, True)):
        words = ["simulate", "--speed", f"0:{-share * most:.0f}", "--duration", "0.05"]
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0
        assert (f"the drive follows at most {most:.0f} r/min, not" in done.output) == noted


def test_a_run_that_an_evaluation_counts_as_not_held_says_so() -> None:
    """A speed loop that is much too fast for the observer swings the shaft."""
    design = DriveDesign(speed_hz=14.0)
    scenarios = suite("impact", MOTOR, 7, 88)
    loose = score(make_policy("eq25", MOTOR), scenarios, SimFactory(MOTOR, design))
    swings = (loose.lost == 0) & (loose.metrics["not_held"] == 1.0)
    assert swings.any() and not swings.all()
    for found in (True, False):
        row = int(np.argmax(swings == found))
        told = outcome(
            trace(make_policy("eq25", MOTOR), scenarios[row : row + 1], MOTOR, design, go_on=True)
        )
        assert told.startswith("kept lock") and ("(not held)" in told) == found, told


def test_a_motor_file_is_no_policy(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is a motor file; give it to --motor"):
        make_policy(str(tmp_path / "mine.toml"), MOTOR)

"""What a run, a plan or a policy that went wrong is told by."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.returns import acts
from sensorless.envs.scenarios.words import plan_from
from sensorless.errors import UserError
from sensorless.evaluation.trace import outcome, trace
from sensorless.evaluation.trace_summary import plateaus
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

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


def test_a_motor_file_is_no_policy(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is a motor file; give it to --motor"):
        make_policy(str(tmp_path / "mine.toml"), MOTOR)


def test_a_policy_with_act_alone_acts() -> None:
    class Always:
        def act(self, obs: np.ndarray) -> np.ndarray:
            return np.ones(len(obs), np.float32)

    env = BlendVectorEnv(2)
    obs, _ = env.reset(seed=1)
    assert np.all(acts(Always(), env)(obs)[:, 0] == 1.0)  # type: ignore[arg-type]

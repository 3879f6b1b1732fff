"""When a learning curve passes a level, and the levels of a run's own scenarios."""

import json
import shutil
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from sensorless.agents.train.curve import COLUMNS
from sensorless.design.carried import carried
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.validation import validate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.helpers.script import script

ROOT = Path(__file__).parents[2]
MOTOR = Motor.load("paper")


@pytest.fixture(scope="module")
def learning() -> ModuleType:
    return script("studies/learning_time.py")


@pytest.mark.parametrize(
    ("level", "seconds", "stays"), [(0.41, 10.0, False), (0.4, 20.0, False), (0.21, 40.0, True)]
)
def test_the_first_validation_below_counts(
    learning: ModuleType, level: float, seconds: float, stays: bool
) -> None:
    curve = {
        "seconds": np.array([0.0, 10.0, 20.0, 30.0, 40.0]),
        "steps": np.array([0.0, 1e6, 2e6, 3e6, 4e6]),
        "objective": np.array([0.9, 0.4, 0.3, 0.5, 0.2]),
    }
    found = learning.crossing(curve, level)
    assert found == {"seconds": seconds, "steps": int(seconds * 1e5), "stays": stays}
    assert learning.crossing(curve, 0.2) is None


def test_a_run_is_held_against_the_rule_on_its_own_scenarios(
    learning: ModuleType, tmp_path: Path
) -> None:
    run = tmp_path / "run"
    run.mkdir()
    config = json.loads((ROOT / "results" / "reference" / "config.json").read_text())
    config["train"]["validate_size"] = 24
    config["set"]["smo_pll_hz"] = 25.0
    (run / "config.json").write_text(json.dumps(config))
    factory = SimFactory(MOTOR, DriveDesign(**carried(config, "run").settings))
    level = validate(make_policy("linear-tuned", MOTOR), factory, 24).objective
    best = level - 0.001
    rows = [(0, 0.0, level), (1000, 50.0, best), (2000, 90.0, level + 0.001)]
    text = "".join(f"{a},{b},1,1,1,{c!r},0\n" for a, b, c in rows)
    (run / "progress.csv").write_text(",".join(COLUMNS) + "\n" + text)
    found = learning.study(run, "linear-tuned", "constant:1")
    assert found["rule"] == {"seconds": 50.0, "steps": 1000, "stays": False}
    assert found["best"] == {"objective": best, "seconds": 50.0}
    assert found["levels"]["linear-tuned"]["objective"] == level
    assert found["levels"]["constant:1"]["objective"] != level
    assert learning.in_time({"run": found}, "rule") == 1
    found["rule"]["seconds"] = 121.0
    assert learning.in_time({"run": found, "other": {"rule": None}}, "rule") == 0


def test_a_folder_that_is_no_run_is_refused(learning: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="learning curve"):
        learning.study(tmp_path, "linear-tuned", "eq25")
    shutil.copy(ROOT / "results" / "reference" / "progress.csv", tmp_path)
    with pytest.raises(UserError, match="config"):
        learning.study(tmp_path, "linear-tuned", "eq25")

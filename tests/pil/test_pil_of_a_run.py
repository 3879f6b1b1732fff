"""From training to the target: `sensorless pil` on the folder of a trained run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.export.export import table_of
from sensorless.machine.motor import Motor
from sensorless.pil import pil as loop
from sensorless.policies.registry import make_policy, table_named
from tests.helpers.scenarios import on_the_target

START = table_named("eq25", Motor.load("paper"))

SMALL = TrainConfig(n_envs=16, n_steps=16, n_epochs=1, steps=512, warm_up=1, validate_size=16)


@pytest.mark.usefixtures("target", "brief", "without_selftest")
@pytest.mark.parametrize("estimator", ["smo", "flux"])
def test_a_trained_table_runs_on_the_target(
    estimator: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the estimator it was trained on: no ``--set`` here; the default one is in test_pil."""
    monkeypatch.setattr(loop, "pil_scenarios", on_the_target(0.7))
    run, out = tmp_path / "run", tmp_path / "pil.json"
    train(replace(SMALL, lr_nodes=0.05), DriveDesign(estimator=estimator), run, START)
    answer = CliRunner().invoke(app, ["pil", str(run), "--out", str(out)])
    assert answer.exit_code == 0, answer.output
    report = json.loads(out.read_text())
    motor = Motor.load("paper")
    learned, start = (table_of(make_policy(name, motor), name) for name in (str(run), "eq25"))
    assert report["table_digest"] == learned.digest, "the run's own table was on the target"
    assert learned.values.shape != start.values.shape or np.any(learned.values != start.values)
    assert report["mismatches"] == report["lookup_mismatches"] == 0
    assert report["estimator"] == estimator
    assert report["periods"] > 50_000, "both together more than 100,000"
    assert report["seconds"] < 120.0

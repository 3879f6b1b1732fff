"""Which schedule of a run is kept: its mean over the updates, by the run's own objective."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from torch import Tensor

from sensorless.agents.table.policy import TableActorCritic
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.design.drive import DriveDesign
from sensorless.evaluation.objective import Cost
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.policy import TablePolicy

pytestmark = pytest.mark.usefixtures("brief")

SMALL = TrainConfig(
    n_envs=16, n_steps=16, n_epochs=1, steps=1024, warm_up=1, validate_size=16,
    start="linear:100,900",
)  # fmt: skip
START = table_named(SMALL.start, Motor.load("paper"))
VALIDATED = "sensorless.agents.train.watch.validate_all"


@pytest.mark.parametrize(("weight", "kept"), [(0.0, "start"), (1.0, "end")])
def test_the_runs_own_weight_of_ripple_chooses(
    weight: float, kept: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All but the first validation have less ripple and more deviation: 0.29 instead of 0.30."""
    costs = iter([Cost(0.0, 0.20, 0.10)])
    monkeypatch.setattr(VALIDATED, lambda *of: next(costs, Cost(0.0, 0.25, 0.04)))
    train(replace(SMALL, ripple_weight=weight), DriveDesign(), tmp_path / "run", START)
    table = json.loads((tmp_path / "run/table.json").read_text())
    assert (table["provenance"]["steps"] > 0) == (kept == "end")


def test_what_is_validated_is_the_mean_over_the_updates(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of as many as the run has, without weights."""
    actors: list[Floats] = []
    validated: list[Floats] = []
    vector = TableActorCritic.vector

    def noted(self: TableActorCritic) -> Tensor:
        actors.append(vector(self).numpy().astype(np.float64))
        return vector(self)

    def seen(schedule: TablePolicy, *of: Any) -> Cost:
        validated.append(schedule.table.values.reshape(-1).astype(np.float64))
        return Cost(0.0, 1.0 / len(validated), 0.0)

    monkeypatch.setattr(TableActorCritic, "vector", noted)
    monkeypatch.setattr(VALIDATED, seen)
    train(replace(SMALL, average=100), DriveDesign(), tmp_path / "run", START)
    mean = np.clip(np.mean(actors[1:], axis=0), 0.0, 1.0)  # the first is validated before any
    last = np.clip(actors[-1], 0.0, 1.0)
    assert validated[-1] == pytest.approx(mean, abs=1e-6)
    assert np.abs(last - mean).max() > 1e-5, "the run moved"

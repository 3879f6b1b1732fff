"""The same seed and number of decisions give the same schedule to the bit."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stable_baselines3.common.save_util import load_from_zip_file

from sensorless.agents.loading import load_run
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.run_folder import LATEST
from sensorless.agents.train.train import train
from sensorless.core.api import SIGNAL_N
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named

START = table_named("eq25", Motor.load("paper"))

SMALL = TrainConfig(
    n_envs=32, n_steps=16, n_epochs=2, minutes=0.0, steps=1536, warm_up=1, validate_size=16,
    eval_freq=512, average=2,
)  # fmt: skip


def trained(config: TrainConfig, folder: Path) -> tuple[dict[str, bytes], list[str], str]:
    """Parameters at the end, the learning curve without its clock, and the best schedule."""
    train(config, DriveDesign(), folder, START)
    _, parameters, _ = load_from_zip_file(folder / LATEST, load_data=False, device="cpu")
    state: Any = parameters["policy"]
    weights = {k: v.numpy().tobytes() for k, v in state.items()}
    rows = (folder / "progress.csv").read_text().splitlines()
    policy = load_run(folder, Motor.load("paper"))
    obs = np.random.default_rng(0).uniform(0.0, 1.0, (200, SIGNAL_N)).astype(np.float32)
    return weights, [",".join(np.delete(row.split(","), 1)) for row in rows], str(policy.act(obs))


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("kind", ["table", "mlp"])
def test_to_the_bit_whatever_the_clock_says(tmp_path: Path, kind: str) -> None:
    config = replace(SMALL, policy_kind=kind)
    first, again = (trained(config, tmp_path / name) for name in ("first", "again"))
    assert first == again
    assert len(first[1]) > 3, "validated by decisions, not by the clock"
    other = trained(replace(config, seed=2, steps=512), tmp_path / "other")
    actor = "actor.values" if kind == "table" else "mlp_extractor.actor.0.weight"
    assert other[0][actor] != first[0][actor]

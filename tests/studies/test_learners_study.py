"""Learners beside PPO: they act as their table does, and each gets its budget."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import torch

from sensorless.agents.train import env as train_env
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import training_env, training_scenarios
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import SUITES
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.policy import TablePolicy
from tests.helpers.scenarios import cut
from tests.helpers.script import script

MOTOR, DESIGN, N = Motor.load("paper"), DriveDesign(estimator="smo"), 6


@pytest.fixture(scope="module")
def learners() -> ModuleType:
    return script("studies/learners_study.py")


def test_an_episode_earns_what_the_table_earns(learners: ModuleType) -> None:
    config = TrainConfig(n_envs=N, start="linear:200,500", axes="speed:0:1:31")
    table = config.start_table(table_named(config.start, MOTOR), MOTOR, DESIGN.k_s_slew)
    actor, size = learners.actor_of(config, table)
    nodes = actor.vector().reshape(1, 1, -1).expand(N, -1, -1)
    env = training_env(config, DESIGN, [MOTOR])
    got = learners.earned(env, actor, nodes, list(range(5, 5 + N)))
    other = BlendVectorEnv(
        N, motor=MOTOR, design=DESIGN, decision_period=5e-3, scenarios=training_scenarios
    )
    want = returns(other, acts(TablePolicy("table", actor.table()), other), 5)
    assert got.numpy() == pytest.approx(want, rel=1e-3)
    assert size.tolist() == [[pytest.approx(config.noise)]]
    opposite = nodes + torch.tensor([0.1, -0.1]).repeat(N // 2)[:, None, None]
    assert np.ptp(learners.earned(env, actor, opposite, [5] * N).numpy()) > 0.0


def test_every_learner_is_judged(
    learners: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In two updates, of scenarios of 0.5 s."""
    for name, value in {"n_envs": 24, "n_steps": 50, "warm_up": 0}.items():
        monkeypatch.setitem(learners.SHARED, name, value)
    monkeypatch.setattr(train_env, "stress_1_scenarios", cut(stress_1_scenarios, 0.5))
    monkeypatch.setitem(SUITES, "hard-train", cut(SUITES["hard-train"], 0.5))
    monkeypatch.setattr(learners, "STEPS", dict.fromkeys(learners.STEPS, 0.2))
    monkeypatch.setattr(learners, "LAST", 1)
    out = tmp_path / "learners.json"
    words = ["gains", "--seeds", "1", "--steps", "2400", "--size", "8", "--out", str(out)]
    monkeypatch.setattr(sys, "argv", ["learners_study", *words, "--learners", "ppo", "es", "cma"])
    learners.main()
    found = json.loads(out.read_text())["gains"]
    assert list(found["learners"]) == [learners.START, "ppo", "es", "cma"]
    start = found["learners"][learners.START]
    agents = [x["seeds"][0] for who, x in found["learners"].items() if who != learners.START]
    errors = {(x["torque_dev_rms"], x["injection_share"]) for x in [*agents, start]}
    assert len(errors) == 4, "each moved, none like another"

"""A table that also sets gains, as PPO trains it."""

from dataclasses import replace
from pathlib import Path

import gymnasium
import numpy as np
import pytest
import torch

from sensorless.agents.loading import load_run
from sensorless.agents.table.policy import TableActorCritic
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import training_env
from sensorless.agents.train.train import train
from sensorless.core.api import SIGNAL_N
from sensorless.design.drive import DriveDesign
from sensorless.envs.privileged import N_PRIVILEGED
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.policy import TablePolicy, gains_of
from sensorless.table.ks_table import Axis, GainGrid, KsTable

pytestmark = pytest.mark.usefixtures("brief")


AXES = (Axis("speed", 0.0, 1.0, 6), Axis("torque_current", -1.5, 1.5, 4))
WIDTH = SIGNAL_N + N_PRIVILEGED


@pytest.fixture
def net() -> TableActorCritic:
    rng = np.random.default_rng(1)
    grids = (
        GainGrid("observer", rng.uniform(-1, 1, (6, 4)).astype(np.float32)),
        GainGrid("amplitude", rng.uniform(-1, 0, (6, 4)).astype(np.float32)),
    )
    return TableActorCritic(
        gymnasium.spaces.Box(-10.0, 10.0, (WIDTH,)),
        gymnasium.spaces.Box(-1.0, 1.0, (3,)),
        lambda _: 1e-3,
        table=KsTable(AXES, rng.random((6, 4), dtype=np.float32), gains=grids),
        lr_nodes=2e-3,
        noise=0.1,
        smoothness=1.0,
        value_scale=20.0,
        hidden=16,
    )


def test_the_mean_action_is_what_the_table_gives(net: TableActorCritic) -> None:
    obs = np.random.default_rng(2).uniform(-0.5, 1.5, (200, WIDTH)).astype(np.float32)
    action, _ = net.predict(obs, deterministic=True)
    table = net.actor.table()
    signals = np.ascontiguousarray(obs[:, :SIGNAL_N])
    np.testing.assert_array_equal(action[:, 0], 2.0 * table.evaluate(signals) - 1.0)
    np.testing.assert_allclose(action[:, 1:], table.evaluate_gains(signals)[:, [0, 3]], atol=1e-6)


def test_the_start_comes_back_unchanged(net: TableActorCritic) -> None:
    given = net.actor.table(net.vector())
    assert given.digest == net.actor.table().digest
    assert [grid.gain for grid in given.gains] == ["observer", "amplitude"]


def test_each_output_explores_on_its_own_and_opposite_in_a_pair(net: TableActorCritic) -> None:
    net.reset_noise(4)
    obs = torch.full((4, WIDTH), 0.4)
    action = net.get_distribution(obs).sample() - net.get_distribution(obs).mode()
    torch.testing.assert_close(action[0::2], -action[1::2])
    assert len(set(action[0].detach().numpy().round(6).tolist())) == 3


def test_a_run_moves_gains_and_keeps_them(tmp_path: Path, motor: Motor) -> None:
    config = TrainConfig(n_envs=16, n_steps=16, batch_size=128, n_epochs=1, steps=1024, warm_up=0,
                         validate_size=16, gains="amplitude,observer")  # fmt: skip
    train(config, DriveDesign(), tmp_path / "run", table_named("eq25", motor))
    policy = load_run(tmp_path / "run", motor)
    assert isinstance(policy, TablePolicy)
    assert list(gains_of(policy)) == ["observer", "amplitude"]
    from stable_baselines3 import PPO

    model = PPO.load(tmp_path / "run" / "checkpoints" / "latest.zip", device="cpu")
    moved = model.policy.actor.gains.detach()  # type: ignore[operator, union-attr]
    assert moved.abs().sum() > 0.0 and moved[1].max() <= 0.0


def test_a_gain_may_have_a_range_of_its_own(motor: Motor) -> None:
    config = TrainConfig(gains="amplitude:0.5:1.5, observer")
    assert list(config.gain_ranges) == ["observer", "amplitude"]
    table = config.start_table(table_named("eq25", motor), motor, 50.0)
    assert [(g.low, g.high) for g in table.gains] == [(0.5, 2.0), (0.5, 1.5)]
    assert training_env(config, DriveDesign(), [motor]).action_space.shape == (3,)
    for words in ("amplitude:0.5", "amplitude:low:1.5"):
        with pytest.raises(UserError, match="write amplitude, or amplitude:LOW:HIGH"):
            TrainConfig(gains=words)
    with pytest.raises(UserError, match="low"):
        TrainConfig(gains="amplitude:1.2:1.5")


def test_gains_of_the_start_are_kept_or_asked_for(motor: Motor) -> None:
    """With its axes and ranges; a run that would lose or scale them is refused with the words."""
    base = TrainConfig().start_table(table_named("eq25", motor), motor, 50.0)
    values = np.full(base.values.shape, 0.5, dtype=np.float32)
    source = replace(base, gains=(GainGrid("amplitude", values, 0.5, 1.5),))
    asked = "amplitude:0.5:1.5"
    for axes in (TrainConfig.axes, "start"):
        table = TrainConfig(gains=f"observer,{asked}", axes=axes).start_table(source, motor, 50.0)
        found = {grid.gain: grid.values for grid in table.gains}
        assert np.all(found["amplitude"] == 0.5) and np.all(found["observer"] == 0.0)
    other = {"gains": asked, "axes": "speed:0:1:32,disagreement:-1.5:1.5:9"}
    for wrong in ({}, {"gains": "amplitude"}, other):
        with pytest.raises(UserError, match=f"--axes start --gains {asked}"):
            TrainConfig(**wrong).start_table(source, motor, 50.0)  # type: ignore[arg-type]


def test_unknown_gains_are_refused() -> None:
    with pytest.raises(UserError, match="'speed' is unknown; choose from observer"):
        TrainConfig(gains="speed")
    with pytest.raises(UserError, match="'observer' is given twice; give it once"):
        TrainConfig(gains="observer:0.5:2,observer")
    with pytest.raises(UserError, match="only a table sets them"):
        TrainConfig(gains="l_q", policy_kind="mlp")

"""Pairs of environments: opposite noise, one scenario, and the difference as advantage."""

import numpy as np
import pytest
import torch
from gymnasium import spaces

from sensorless.agents.pairs import PairedRolloutBuffer, opposite, paired_seeds
from sensorless.agents.table.kernel import NodeKernel
from sensorless.agents.table.noise import NodeNoise
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import training_env, training_scenarios, with_others
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import Motor


def test_partners_see_the_same_scenario_to_the_bit() -> None:
    config = TrainConfig(n_envs=4)
    env = training_env(config, DriveDesign(), [Motor.load("paper")])
    env.seed_each(paired_seeds(7, 4))
    first = np.asarray(env.reset())
    assert np.array_equal(first[0::2], first[1::2])
    assert not np.array_equal(first[0], first[2])
    for _ in range(20):
        seen, reward, _, _ = env.step(np.zeros((4, 1), dtype=np.float32))
        obs = np.asarray(seen)
        assert np.array_equal(obs[0::2], obs[1::2]) and np.array_equal(reward[0::2], reward[1::2])


def test_partners_explore_in_opposite_directions() -> None:
    torch.manual_seed(0)
    noise = NodeNoise(NodeKernel((4, 3), 1.0))
    noise.draw(6)
    assert torch.equal(noise.z[0::2], -noise.z[1::2])
    assert not torch.equal(noise.z[0], noise.z[2])
    assert opposite(torch.arange(2.0)).tolist() == [0.0, -0.0, 1.0, -1.0]


def filled(rewards: np.ndarray, starts: np.ndarray, outlier: float = 0.0) -> PairedRolloutBuffer:
    """Buffer with values 0, so that the advantage of a rollout is what it earned."""
    steps, n = rewards.shape
    box = spaces.Box(-1.0, 1.0, (1,))
    buffer = PairedRolloutBuffer(steps, box, box, gae_lambda=1.0, gamma=1.0, n_envs=n,
                                 outlier=outlier)  # fmt: skip
    buffer.rewards[:], buffer.episode_starts[:] = rewards, starts
    buffer.compute_returns_and_advantage(torch.zeros(n), np.zeros(n, dtype=bool))
    return buffer


def test_every_step_gets_half_of_what_the_rollout_earned_more_than_the_partners() -> None:
    rewards = np.random.default_rng(1).normal(size=(5, 4)).astype(np.float32)
    found = filled(rewards, np.zeros((5, 4))).advantages
    gain = rewards.sum(axis=0)
    expected = 0.5 * np.array([gain[0] - gain[1], gain[1] - gain[0],
                               gain[2] - gain[3], gain[3] - gain[2]])  # fmt: skip
    np.testing.assert_allclose(found, np.tile(expected, (5, 1)), rtol=1e-5)


def test_partners_that_parted_have_nothing_in_common_until_a_restart() -> None:
    """Also in later rollouts, in which none begins an episode."""
    starts = np.zeros((3, 4))
    starts[0], starts[2, 1] = 1.0, 1.0
    rewards = np.ones((3, 4), dtype=np.float32) * [1.0, 0.0, 1.0, 0.0]
    buffer = filled(rewards.astype(np.float32), starts)
    assert not buffer.advantages[2, :2].any() and buffer.advantages[:2, :2].all()
    found = []
    for joins in (False, True):
        buffer.reset()
        if joins:
            buffer.join()
        buffer.rewards[:], buffer.episode_starts[:] = rewards, 0.0
        buffer.compute_returns_and_advantage(torch.zeros(4), np.zeros(4, dtype=bool))
        found.append(buffer.advantages[:, 0::2] != 0.0)
    assert not found[0][:, 0].any() and found[0][:, 1].all()
    assert found[1].all()


def test_one_lost_scenario_counts_a_few_times_the_usual_difference() -> None:
    gain = np.ones((1, 400), dtype=np.float32)
    gain[0, 1::2] = -1.0
    gain[0, 7] = -2000.0
    found = filled(gain, np.zeros((1, 400)), outlier=5.0).advantages[0]
    np.testing.assert_allclose(np.delete(found, [6, 7]), np.delete(gain[0], [6, 7]), rtol=1e-6)
    np.testing.assert_allclose(found[6:8], [5.0, -5.0], rtol=1e-3)


def test_a_share_of_the_scenarios_is_hard_and_each_follows_from_its_seed() -> None:
    motor, seeds = Motor.load("paper"), np.arange(600, dtype=np.uint64)
    usual, mixed = training_scenarios(motor, seeds), with_others({"hard-train": 0.25})(motor, seeds)
    hard = (usual.seed != mixed.seed) | (usual.t != mixed.t).any(axis=1)
    assert 0.18 < hard.mean() < 0.32
    one = with_others({"hard-train": 0.25})(motor, seeds[41:42])
    assert np.array_equal(one.omega, mixed.omega[41:42]) and one.J[0] == mixed.J[41]
    moved = mixed.omega[hard]
    assert len(np.unique(moved, axis=0)) == len(moved), "none is repeated"


def test_suites_share_the_scenarios_without_moving_those_of_each_other() -> None:
    motor, seeds = Motor.load("paper"), np.arange(400, dtype=np.uint64)
    usual, hard = training_scenarios(motor, seeds), with_others({"hard-train": 0.2})(motor, seeds)
    mixed = with_others({"hard-train": 0.2, "low-inertia": 0.5, "mismatch": 0.3})(motor, seeds)
    of_hard = usual.seed != hard.seed
    assert (mixed.t[of_hard] == hard.t[of_hard]).all()
    light = ~of_hard & (mixed.J <= 0.5)
    assert 0.4 < light.mean() < 0.6
    rest = ~of_hard & ~light
    assert 0.22 < rest.mean() < 0.38 and mixed.R_s[rest].max() > usual.R_s.max()
    assert with_others({"low-inertia": 1.0})(motor, seeds).J.max() <= 0.5


def test_shares_of_other_suites_above_one_are_refused() -> None:
    with pytest.raises(
        UserError, match=r"hard, low_inertia, mismatch: 0\.5, 0\.4, 0\.2: .* at most 1"
    ):
        TrainConfig(hard=0.5, low_inertia=0.4, mismatch=0.2)


def test_nothing_is_learned_from_a_pair_out_of_step() -> None:
    rewards, starts = np.ones((5, 4), dtype=np.float32), np.zeros((5, 4))
    starts[3, 1] = 1.0  # lost with its third decision: the fourth belongs to another scenario
    rewards[2, 1] = -100.0
    found = filled(rewards, starts).advantages
    assert np.all(found[3:, :2] == 0.0)
    np.testing.assert_allclose(found[:3, 0], 0.5 * (5.0 - (2.0 - 100.0)))
    np.testing.assert_allclose(found[:3, 1], -found[:3, 0])
    assert np.all(found[:, 2:] == 0.0)  # no difference, no advantage


def test_an_odd_number_of_environments_is_refused() -> None:
    with pytest.raises(UserError, match="n_envs: 5: must be even"):
        TrainConfig(n_envs=5)

from typing import Any

import numpy as np
import pytest

from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds
from sensorless.envs.privileged import N_PRIVILEGED
from sensorless.envs.reward import TERMS
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.signals import N_SIGNALS
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

N = 4


def brief(motor: Motor, seeds: Seeds) -> Scenarios:
    """Episodes of 4 to 16 ms, some of which lose lock."""
    scenarios = stress_1_scenarios(motor, seeds)
    scenarios.duration = 0.004 + 0.001 * (seeds % np.uint64(13)).astype(float)
    scenarios.theta_err_0 = np.where(seeds % np.uint64(3) == 0, 2.0, scenarios.theta_err_0)
    return scenarios


def make(privileged: bool = False, mode: str = "SameStep") -> SB3VecEnv:
    env = BlendVectorEnv(N, autoreset_mode=mode, scenarios=brief)
    return SB3VecEnv(env, privileged=privileged)


def test_next_step_mode_is_refused() -> None:
    with pytest.raises(UserError, match=r"autoreset_mode: 'NextStep'; .* needs 'SameStep'"):
        make(mode="NextStep")


def test_one_drive_of_gymnasium_is_refused_in_words() -> None:
    with pytest.raises(UserError, match=r"env: .*; give BlendVectorEnv, as gymnasium.make_vec"):
        SB3VecEnv(BlendEnv())  # type: ignore[arg-type]


@pytest.mark.parametrize("privileged", [False, True])
def test_terminal_observation_is_the_last_of_the_old_episode(privileged: bool) -> None:
    env = make(privileged)
    env.seed(20)
    observation: Any = env.reset()
    singles = [BlendEnv(scenarios=brief) for _ in range(N)]
    seen = [single.reset(seed=20 + i) for i, single in enumerate(singles)]
    width = N_SIGNALS + (N_PRIVILEGED if privileged else 0)

    def row(part: Any, info: dict[str, Any]) -> Any:
        return np.concatenate([part, info["privileged"]])[:width]

    assert np.array_equal(observation, [row(o, info) for o, info in seen])
    ends = {True: 0, False: 0}
    rng = np.random.default_rng(0)
    for _ in range(80):
        action = rng.uniform(-1.0, 1.0, (N, 1)).astype(np.float32)
        observation, reward, done, infos = env.step(action)
        assert observation.shape == (N, width) and observation.dtype == np.float32
        assert len({id(info) for info in infos}) == N
        for i, single in enumerate(singles):
            expected, value, terminated, truncated, info = single.step(action[i])
            last = row(expected, info)
            assert (reward[i], done[i]) == (value, terminated or truncated)
            assert bool(infos[i]) == done[i], "keys of an end only at an end"
            if done[i]:
                ends[truncated] += 1
                assert np.array_equal(infos[i]["terminal_observation"], last)
                assert infos[i]["TimeLimit.truncated"] is truncated
                assert infos[i]["lost"] is terminated
                last = row(*single.reset())
            assert np.array_equal(observation[i], last)
        assert np.array_equal(sum(env.last_info[name] for name in TERMS), reward)
    assert min(ends.values()) > 2, "the test has to see both ends"


def test_observation_kept_by_the_buffer_does_not_change() -> None:
    env = make()
    env.seed(1)
    kept: list[Any] = [env.reset()]
    copies = [kept[0].copy()]
    for _ in range(10):
        kept.append(env.step(np.zeros((N, 1), np.float32))[0])
        copies.append(kept[-1].copy())
    assert np.array_equal(kept, copies)


def test_seed_counts_once() -> None:
    env = make()
    env.seed(3)
    first = env.reset()
    assert not np.array_equal(first, env.reset())
    env.seed(3)
    assert np.array_equal(first, env.reset())


def test_attributes() -> None:
    env = make()
    assert env.get_attr("num_envs", [0, 2]) == [N, N]
    assert env.get_attr("render_mode") == [None] * N and env.render_mode is None
    env.set_attr("name", "x")
    assert env.get_attr("name", 1) == ["x"]
    with pytest.raises(NotImplementedError):
        env.set_attr("name", "y", 1)
    with pytest.raises(NotImplementedError):
        env.env_method("reset")
    env.close()


def test_ppo_learns_and_evaluates_on_it() -> None:
    from stable_baselines3 import PPO
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.vec_env import VecMonitor

    env = VecMonitor(make(privileged=True))
    model = PPO("MlpPolicy", env, n_steps=32, batch_size=64, n_epochs=1, seed=1, device="cpu")
    model.learn(256)
    mean, _ = evaluate_policy(model, env, n_eval_episodes=8)
    assert np.isfinite(mean)

import copy
import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import DictInfoToList, RecordEpisodeStatistics

from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds
from sensorless.envs.reward import TERMS
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

N = 5
NOT_A_SEED: Any = "x"


def brief(motor: Motor, seeds: Seeds) -> Scenarios:
    """Episodes of 4 to 16 ms, some of which lose lock."""
    scenarios = stress_1_scenarios(motor, seeds)
    scenarios.duration = 0.004 + 0.001 * (seeds % np.uint64(13)).astype(float)
    scenarios.theta_err_0 = np.where(seeds % np.uint64(3) == 0, 2.0, scenarios.theta_err_0)
    return scenarios


def actions(n: int, steps: int) -> Any:
    return np.random.default_rng(1).uniform(-1.0, 1.0, (steps, n, 1)).astype(np.float32)


def make(n: int, mode: str = "NextStep", **settings: Any) -> BlendVectorEnv:
    return BlendVectorEnv(n, autoreset_mode=mode, **{"scenarios": brief, **settings})


def same(a: Any, b: Any) -> bool:
    return data_equivalence(a, b, exact=True)


def test_make_vec_gives_the_native_batch() -> None:
    env = gymnasium.make_vec("sensorless:sensorless/Blend-v0", num_envs=3, max_episode_steps=2)
    assert isinstance(env.unwrapped, BlendVectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    observation, info = env.reset(seed=1)
    assert env.observation_space.contains(observation) and info["privileged"].shape[0] == 3
    truncated = [env.step(env.action_space.sample())[3].all() for _ in range(4)]
    assert truncated == [False, True, False, False]


def test_true_counts_as_one() -> None:
    """As for other whole numbers; NumPy takes no truth for a size."""
    assert make(True).reset(seed=1)[0].shape == (1, 12)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_equals_single_environments_to_the_bit(mode: str) -> None:
    """Observations, rewards, ends and infos over many episodes with autoreset."""
    vector = make(N, mode)
    singles = [BlendEnv(scenarios=brief) for _ in range(N)]
    first, info = vector.reset(seed=40)
    for i, env in enumerate(singles):
        observation, single_info = env.reset(seed=40 + i)
        assert np.array_equal(observation, first[i])
        assert np.array_equal(single_info["privileged"], info["privileged"][i])
    over = np.zeros(N, dtype=bool)
    ends = losses = 0
    for action in actions(N, 120):
        observation, reward, terminated, truncated, info = vector.step(action)
        for i, env in enumerate(singles):
            if over[i] and mode == "NextStep":
                expected, single_info = env.reset()
                assert (reward[i], terminated[i], truncated[i]) == (0.0, False, False)
                assert not info["_lost"][i] and not info["_angle"][i] and info["_privileged"][i]
                over[i] = False
            else:
                expected, *rest, single_info = env.step(action[i])
                assert rest == [reward[i], terminated[i], truncated[i]]
                assert all(info[name][i] == single_info[name] for name in (*TERMS, "lost"))
                over[i] = terminated[i] or truncated[i]
                ends, losses = ends + over[i], losses + terminated[i]
                if over[i] and mode == "SameStep":
                    assert info["_final_obs"][i] and np.array_equal(info["final_obs"][i], expected)
                    final = {k: v[i] for k, v in info["final_info"].items() if k[0] != "_"}
                    assert np.array_equal(final.pop("privileged"), single_info["privileged"])
                    assert final == {name: single_info[name] for name in final}
                    expected, single_info = env.reset()
            assert np.array_equal(observation[i], expected)
            assert np.array_equal(info["privileged"][i], single_info["privileged"])
    assert ends > 20 and losses > 3, "the test has to see many ends"


def test_size_of_the_batch_does_not_matter() -> None:
    small, large = make(2), make(64)
    assert np.array_equal(small.reset(seed=9)[0], large.reset(seed=9)[0][:2])
    for action in actions(64, 40):
        a, b = small.step(action[:2]), large.step(action)
        for x, y in zip(a[:4], b[:4], strict=True):
            assert np.array_equal(x, y[:2])


def test_terms_add_up_to_the_reward() -> None:
    env = make(N, "SameStep")
    env.reset(seed=2)
    for action in actions(N, 60):
        _, reward, terminated, _, info = env.step(action)
        assert reward == pytest.approx(np.sum([info[name] for name in TERMS], axis=0), rel=1e-5)
        assert np.array_equal(terminated, info["lost"])
        assert np.array_equal(terminated, info["lost_penalty"] < 0.0)
        assert all(np.all(info[name] <= 0.0) for name in TERMS)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_nothing_returned_changes_later(mode: str) -> None:
    env = make(N, mode)
    kept: list[Any] = [env.reset(seed=3)]
    frozen = [pickle.dumps(kept[0])]
    for action in actions(N, 30):
        kept.append(env.step(action))
        frozen.append(pickle.dumps(kept[-1]))
    assert [pickle.dumps(x) for x in kept] == frozen
    for x in kept[-1][:4]:
        x[...] = 0
    assert env.step(actions(N, 1)[0])[0].any(), "what a user overwrites is the user's"


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("how", ["deepcopy", "pickle", "state"])
def test_copies_continue_identically(mode: str, how: str) -> None:
    env = make(N, mode)
    env.reset(seed=6)
    for action in actions(N, 25):
        env.step(action)
    if how == "state":
        twin = make(N, mode)
        twin.restore(env.state())
    else:
        twin = copy.deepcopy(env) if how == "deepcopy" else pickle.loads(pickle.dumps(env))
    for action in actions(N, 40):
        assert same(env.step(action)[:4], twin.step(action)[:4])


def test_seeds() -> None:
    env = make(3)
    runs = []
    for seed in (7, 7, [7, 8, 9], 8):
        observation = [env.reset(seed=seed)[0], env.reset()[0]]
        observation += [env.step(action)[0] for action in actions(3, 20)]
        runs.append(np.array(observation))
    assert np.array_equal(runs[0], runs[1]) and np.array_equal(runs[0], runs[2])
    assert np.array_equal(runs[0][:2, 1:], runs[3][:2, :2]), "drive i has seed + i"
    env.reset(seed=[None, 1, None])
    assert env.reset(seed=2**64 - 3)[0].shape[0] == 3, "the largest seed of three drives"


def test_unseeded_environments_differ() -> None:
    one, other = make(3), make(3)
    one.reset()
    other.reset()
    moved = [(one.step(action)[0], other.step(action)[0]) for action in actions(3, 20)]
    assert not all(np.array_equal(a, b) for a, b in moved), "at rest alone they may be alike"


def test_given_scenarios_run_once_then_the_stream_goes_on() -> None:
    env, motor = make(2, "SameStep"), Motor.load("paper")
    given = Scenarios.nominal(motor, np.arange(2, dtype=np.uint64), 0.003)
    env.reset(seed=1, options={"scenario": given})
    for expected in (False, False, True):
        observation, _, _, truncated, _ = env.step(np.zeros((2, 1)))
        assert truncated.tolist() == [expected] * 2
    env.reset(seed=1)
    assert np.array_equal(observation, env.reset()[0])


def test_gymnasium_wrappers_accept_it() -> None:
    env = DictInfoToList(RecordEpisodeStatistics(make(N)))
    env.reset(seed=1)
    lengths = []
    for action in actions(N, 40):
        infos = env.step(action)[4]
        lengths += [info["episode"]["l"] for info in infos if "episode" in info]
    assert len(lengths) > N and max(lengths) <= 16


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: make(2, "Disabled"), "autoreset_mode: 'Disabled'; choose"),
        (lambda: make(2, "same"), "autoreset_mode: 'same'; choose"),
        (lambda: make(2).reset(seed=[1]), r"seed: \[1\]; give .* a list of 2"),
        (
            lambda: make(4).reset(seed=2**64 - 2),
            r"seed: 18446744073709551614; give .* 0 to 2\^64 - 4, one seed for each of 4 drives",
        ),
        (lambda: make(2).reset(seed=[1, NOT_A_SEED]), "seed: 'x'; give"),
        (lambda: make(0), "num_envs: 0; give"),
        (
            lambda: make(2, scenarios=lambda m, s: brief(m, s)[:1]).reset(),
            "scenarios: 1 rows; .* 2 rows",
        ),
        (lambda: make(2, scenarios=lambda m, s: None).reset(), "scenarios: gave None for 2 seeds"),
        (lambda: make(2).restore(make(3).state()), "state: num_envs: it was made with 3, .* 2"),
    ],
)
def test_mistakes_are_named(call: Any, message: str) -> None:
    with pytest.raises(UserError, match=message):
        call()


def test_bad_action_names_its_index() -> None:
    env = make(4)
    with pytest.raises(ResetNeeded):
        env.step(np.zeros((4, 1)))
    env.reset(seed=1)
    action = np.zeros((4, 1), dtype=np.float32)
    action[2] = np.nan
    with pytest.raises(UserError, match=r"action\[2\]: nan; give -1 to 1"):
        env.step(action)
    with pytest.raises(UserError, match=r"action: shape \(3, 1\); give shape \(4, 1\)"):
        env.step(action[:3])

"""Machines side by side behave as each does alone, to the bit."""

from typing import Any

import numpy as np
import pytest

from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.machine_family import family
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.several import FINAL, SeveralMachines
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

MOTORS = (*family(4, 2), Motor.load("pmsyrm_5600w"))
SIZES = (3, 1, 2)
ROWS = (slice(0, 3), slice(3, 4), slice(4, 6))


def brief(motor: Motor, seeds: Seeds) -> Scenarios:
    """Episodes of 4 to 16 ms, some of which lose lock."""
    scenarios = stress_1_scenarios(motor, seeds)
    scenarios.duration = 0.004 + 0.001 * (seeds % np.uint64(13)).astype(float)
    scenarios.theta_err_0 = np.where(seeds % np.uint64(3) == 0, 2.0, scenarios.theta_err_0)
    return scenarios


def envs(mode: str = "SameStep") -> list[BlendVectorEnv]:
    return [
        BlendVectorEnv(n, autoreset_mode=mode, scenarios=brief, motor=motor)
        for n, motor in zip(SIZES, MOTORS, strict=True)
    ]


def test_an_environment_of_one_drive_is_refused() -> None:
    with pytest.raises(UserError, match="envs: BlendEnv; give environments BlendVectorEnv"):
        SeveralMachines([BlendEnv()])  # type: ignore[list-item]


def same(whole: Any, part: Any, rows: slice) -> None:
    for x, y in zip(whole[rows], part, strict=True):
        np.testing.assert_array_equal(x, y)


def test_rows_are_those_of_the_single_machines() -> None:
    several, alone = SeveralMachines(envs()), envs()
    assert several.observation_space.shape == (6, several.single_observation_space.shape[0])  # type: ignore[index]
    obs, info = several.reset(seed=30)
    for env, rows in zip(alone, ROWS, strict=True):
        mine, own = env.reset(seed=30 + rows.start)
        same(obs, mine, rows)
        same(info["privileged"], own["privileged"], rows)
    rng, ended, partly = np.random.default_rng(0), 0, 0
    for _ in range(60):
        action = rng.uniform(-1.0, 1.0, (6, 1)).astype(np.float32)
        *whole, info = several.step(action)
        for env, rows in zip(alone, ROWS, strict=True):
            *part, own = env.step(action[rows])
            for x, y in zip(whole, part, strict=True):
                same(x, y, rows)
            for name in set(own) - set(FINAL):
                same(info[name], own[name], rows)
            assert ("final_obs" in own) <= ("final_obs" in info)
            if "final_obs" in info:
                ended += 1
                partly += "final_obs" not in own
                over = own.get("_final_obs", np.zeros(env.num_envs, dtype=bool))
                same(info["_final_obs"], over, rows)
                same(info["_final_info"], over, rows)
            for i in np.flatnonzero(own.get("_final_obs", [])):
                np.testing.assert_array_equal(info["final_obs"][rows][i], own["final_obs"][i])
                for name, last in own["final_info"].items():
                    np.testing.assert_array_equal(info["final_info"][name][rows][i], last[i])
    assert ended > 20 and partly > 5
    several.close()


def test_a_list_of_seeds_reaches_each_drive() -> None:
    seeds = [9, 3, 5, 77, 1, 2]
    obs, _ = SeveralMachines(envs()).reset(seed=seeds)
    for env, rows in zip(envs(), ROWS, strict=True):
        same(obs, env.reset(seed=seeds[rows])[0], rows)


def test_what_cannot_be_joined_is_refused() -> None:
    with pytest.raises(UserError, match="'SameStep'"):
        SeveralMachines(envs("NextStep"))
    with pytest.raises(UserError, match="no environment"):
        SeveralMachines([])
    slow = BlendVectorEnv(2, autoreset_mode="SameStep", decision_period=2e-3)
    with pytest.raises(UserError, match=r"envs: decision_period: 0\.001 and 0\.002; give one"):
        SeveralMachines([*envs(), slow])
    gains = GainVectorEnv(2, autoreset_mode="SameStep", decision_period=1e-3)
    with pytest.raises(UserError, match=r"envs: gains: \[\] and \[\('observer', Gain"):
        SeveralMachines([*envs(), gains])
    with pytest.raises(UserError, match="options: scenario; several machines take no options"):
        SeveralMachines(envs()).reset(seed=1, options={"scenario": None})


@pytest.mark.parametrize(
    ("seed", "message"),
    [([1, 2], r"seed: \[1, 2\]; give .* a list of 6"), ([1] * 7, "a list of 6"), (-1, "seed: -1")],
)
def test_wrong_seeds_are_named(seed: Any, message: str) -> None:
    with pytest.raises(UserError, match=message):
        SeveralMachines(envs()).reset(seed=seed)


def test_a_seed_of_numpy_is_a_seed() -> None:
    seeds: list[Any] = [1, np.int64(1)]
    whole, again = (SeveralMachines(envs()).reset(seed=seed)[0] for seed in seeds)
    np.testing.assert_array_equal(whole, again)


def test_wrong_actions_are_named_and_nothing_moves() -> None:
    several = SeveralMachines(envs())
    several.reset(seed=1)
    before = [env.state().sims.tobytes() for env in several.envs]
    for n in (5, 7):
        with pytest.raises(UserError, match=rf"action: shape \({n}, 1\); give shape \(6, 1\)"):
            several.step(np.zeros((n, 1)))
    action = np.zeros((6, 1))
    action[4] = np.nan
    with pytest.raises(UserError, match=r"action\[4\]: nan; give -1 to 1"):
        several.step(action)
    assert before == [env.state().sims.tobytes() for env in several.envs]

"""Returns of policies: what an environment can run, and how."""

import copy

import numpy as np
import pytest

from sensorless.core.gains import DEFAULT, GAIN_NAMES
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import design_for, gains_of

MOTOR = Motor.load("paper")


def test_a_policy_with_act_alone_acts() -> None:
    class Always:
        def act(self, obs: np.ndarray) -> np.ndarray:
            return np.ones(len(obs), np.float32)

    env = BlendVectorEnv(2)
    obs, _ = env.reset(seed=1)
    assert np.all(acts(Always(), env)(obs)[:, 0] == 1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("word", "said"),
    [("sensored", "knows the truth"), ("oracle", "knows the truth"),
     ("sliding_mode", "needs a drive with estimator = 'smo'"),
     ("tuned-coupled-machines", "sets the gain observer in a range")],
)  # fmt: skip
def test_a_policy_that_an_environment_cannot_run_is_refused(word: str, said: str) -> None:
    """It would run as another policy, and its return would be said to be its own."""
    with pytest.raises(UserError, match=said):
        acts(make_policy(word, MOTOR), BlendVectorEnv(2))


def test_gains_of_an_own_policy_are_refused_too() -> None:
    class Own:
        ranges = DEFAULT

        def act(self, obs: np.ndarray) -> np.ndarray:
            return np.ones(len(obs), np.float32)

    with pytest.raises(UserError, match="policy Own: sets the gain observer in a range"):
        acts(Own(), BlendVectorEnv(2))  # type: ignore[arg-type]


def test_a_policy_with_gains_acts_where_the_environment_has_them() -> None:
    policy = make_policy("tuned-coupled-machines", MOTOR)
    ranges = dict(gains_of(policy))
    env = GainVectorEnv(
        3, design=design_for(policy, DriveDesign()), gains=tuple(ranges), gain_ranges=ranges
    )
    obs, _ = env.reset(seed=1)
    values = policy.act_gains(obs)  # type: ignore[attr-defined]
    found = acts(policy, env)(obs)
    assert found.shape == (3, 1 + len(ranges)) and np.any(found[:, 1:] != 0.0)
    for j, name in enumerate(ranges):
        np.testing.assert_array_equal(found[:, 1 + j], values[:, GAIN_NAMES.index(name)])


def test_acting_at_another_interval_leaves_a_policy_as_it_is() -> None:
    """``gated`` counts time; it is a copy that counts in steps of the environment."""
    policy = make_policy("gated", MOTOR)
    before = copy.deepcopy(vars(policy))
    acts(policy, GainVectorEnv(2, gains=()))
    assert str(vars(policy)) == str(before)


def test_a_return_ends_with_its_episode_while_another_goes_on() -> None:
    """Each drive earns what it would alone."""
    scenarios = stress_1_scenarios(MOTOR, np.arange(2, dtype=np.uint64))
    scenarios.duration[:] = 0.02, 0.1

    def earned(rows: slice) -> Floats:
        env = BlendVectorEnv(len(scenarios[rows]))
        return returns(env, acts(make_policy("eq25", MOTOR), env), 1, scenarios[rows])

    alone = np.concatenate([earned(slice(0, 1)), earned(slice(1, 2))])
    assert (alone < 0.0).all()
    assert earned(slice(0, 2)) == pytest.approx(alone)

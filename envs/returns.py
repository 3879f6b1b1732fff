"""Undiscounted returns of a policy, one episode per drive."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.signals import Observation
from sensorless.policy import PacedPolicy, Policy

Act = Callable[[Observation], NDArray[np.float32]]
"""From observations (n, N_SIGNALS) to actions (n, m)."""


def returns(
    env: BlendVectorEnv, act: Act, seed: int, scenarios: Scenarios | None = None
) -> NDArray[np.float64]:
    """Returns (n,) of the first episode of each drive, with seeds ``seed``, ``seed`` + 1, ...

    With ``scenarios`` of n rows, these are the episodes.

    The environment must have ``autoreset_mode="NextStep"``, its default.
    """
    obs, _ = env.reset(seed=seed, options=None if scenarios is None else {"scenario": scenarios})
    earned = np.zeros(env.num_envs)
    lives = np.ones(env.num_envs, dtype=bool)
    while lives.any():
        obs, reward, terminated, truncated, _ = env.step(act(obs))
        earned[lives] += reward[lives]
        lives &= ~(terminated | truncated)
    return earned


def acts(policy: Policy, env: BlendVectorEnv) -> Act:
    """Actions of a policy that sets k_s, with all gains of the environment static.

    A policy whose memory counts time then decides at the environment's interval.
    """
    batch = env.batch
    if isinstance(policy, PacedPolicy):
        policy.follow(batch.periods * batch.motor.T_s)
    reset = getattr(policy, "reset", None)  # a policy of the user's own may have act alone
    if reset is not None:
        reset(env.num_envs)

    def act(obs: Observation) -> NDArray[np.float32]:
        actions = np.zeros((len(obs), batch.n_actions), dtype=np.float32)
        actions[:, 0] = 2.0 * policy.act(obs) - 1.0
        return actions

    return act

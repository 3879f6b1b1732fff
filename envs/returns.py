"""Undiscounted returns of a policy, one episode per drive."""

import copy
from collections.abc import Callable
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from sensorless.core.gains import GAIN_NAMES
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.signals import Observation
from sensorless.errors import UserError
from sensorless.policy import (
    PacedPolicy,
    Policy,
    act_gains,
    design_for,
    gains_of,
    require_runnable,
)

Act = Callable[[Observation], NDArray[np.float32]]
"""From observations (n, N_SIGNALS) to actions (n, m)."""


def returns(
    env: BlendVectorEnv, act: Act, seed: int, scenarios: Scenarios | None = None
) -> NDArray[np.float64]:
    """Returns (n,) of the first episode of each drive, with seeds ``seed``, ``seed`` + 1, ...

    With ``scenarios`` of n rows, these are the episodes.
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
    """Actions of a policy on the drive of an environment; gains that it does not set stay static.

    A policy whose memory counts time decides at the environment's interval: as a copy, so that the
    one given stays as it is.

    Raises
    ------
    UserError
        The policy knows the truth, needs another drive, or sets gains otherwise than an action of
        the environment can.
    """
    batch = env.batch
    _check(policy, env)
    columns = [1 + list(batch.settings.ranges).index(name) for name in gains_of(policy)]
    which = [GAIN_NAMES.index(name) for name in gains_of(policy)]
    if isinstance(policy, PacedPolicy):
        policy = copy.deepcopy(policy)
        policy.follow(batch.periods * batch.motor.T_s)
    reset = getattr(policy, "reset", None)  # a policy of the user's own may have act alone
    if reset is not None:
        reset(env.num_envs)

    def act(obs: Observation) -> NDArray[np.float32]:
        actions = np.zeros((len(obs), batch.n_actions), dtype=np.float32)
        actions[:, 0] = 2.0 * policy.act(obs) - 1.0
        if columns:
            actions[:, columns] = act_gains(policy, obs)[:, which]
        return actions

    return act


def _check(policy: Policy, env: BlendVectorEnv) -> None:
    """Refuse what actions of the environment cannot be."""
    name = getattr(policy, "name", type(policy).__name__)
    settings = env.batch.settings
    if hasattr(policy, "sensored"):  # a policy of the user's own may have act alone
        require_runnable(policy)
        has, needs = asdict(settings.design), asdict(design_for(policy, settings.design))
        for key in (key for key, value in needs.items() if value != has[key]):
            raise UserError(
                f"policy {name}: needs a drive with {key} = {needs[key]!r}, the environment's has "
                f"{has[key]!r}; make it with design=design_for(policy, design) of sensorless.policy"
            )
    for gain, x in gains_of(policy).items():
        if settings.ranges.get(gain) != x:
            raise UserError(
                f"policy {name}: sets the gain {gain} in a range that no action of the environment "
                "has; make Blend-v1 with gains=tuple(ranges) and gain_ranges=ranges of "
                "gains_of(policy)"
            )

"""Speed of PPO with the default settings, and the same on an environment that costs nothing.

Steps are decisions of one environment. The free environment has the same spaces, returns the same
arrays at every step, and cuts episodes off after the same time, at which PPO asks its critic.
"""

import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from benchmarks.timing import Run, best_rates
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import training_env
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.agents.train.train import TablePPO, new_model
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.stress import DURATION
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named


class FreeVecEnv(SB3VecEnv):
    """An environment without any work: observations drawn once, rewards 0.

    Drive i is cut off at steps i, i + ``length``, ...
    """

    def __init__(self, like: SB3VecEnv, length: int) -> None:
        self.env = like.env  # the base class asks it for its render_mode
        VecEnv.__init__(self, like.num_envs, like.observation_space, like.action_space)
        n, columns = like.num_envs, like.observation_space.shape or ()
        self._observation = np.random.default_rng(0).random((n, *columns), dtype=np.float32)
        self._zeros = np.zeros(n, dtype=np.float32)
        self._steps = [self._ends(j, n, length) for j in range(length)]
        self._count = 0

    def _ends(self, j: int, n: int, length: int) -> tuple[Any, list[dict[str, Any]]]:
        """Flags and infos of step j."""
        over = np.arange(n) % length == j
        last = {"terminal_observation": self._observation[0], "TimeLimit.truncated": True}
        return over, [dict(last) if end else {} for end in over]

    def reset(self) -> Any:
        """Return the observations."""
        return self._observation

    def step_wait(self) -> VecEnvStepReturn:
        """Return the observations again."""
        over, infos = self._steps[self._count % len(self._steps)]
        self._count += 1
        return self._observation, self._zeros, over, infos


def updates(model: TablePPO) -> Run:
    """One rollout and its gradient steps a turn; counts decisions."""
    config = TrainConfig()
    size = config.n_envs * config.n_steps
    model.set_logger(Logger(folder=None, output_formats=[]))

    def run() -> int:
        model.learn(size, reset_num_timesteps=False)
        return size

    return run


def timed(owner: Any, name: str, key: str, spent: dict[str, float]) -> None:
    """Add the time of every call of a method to ``spent[key]``."""
    inner: Callable[..., Any] = getattr(owner, name)

    def outer(*args: Any, **kwargs: Any) -> Any:
        start = time.perf_counter()
        out = inner(*args, **kwargs)
        spent[key] += time.perf_counter() - start
        return out

    setattr(owner, name, outer)


def measure(seconds: float) -> dict[str, Any]:
    """Steps per second, their ratio, and where the time of training goes."""
    torch.set_num_threads(1)
    config, design, motor = TrainConfig(), DriveDesign(), Motor.load("paper")
    table = config.start_table(table_named("eq25", motor), motor, design.k_s_slew)
    env = training_env(config, design, (motor,))
    env.seed(0)
    model = new_model(config, table, env)
    free = FreeVecEnv(env, round(1e3 * DURATION / config.decision_ms))
    runs = {"drive": updates(model), "free": updates(new_model(config, table, free))}
    rates = best_rates(runs, seconds)

    spent: dict[str, float] = defaultdict(float)
    timed(env, "step_wait", "environment", spent)
    timed(model.policy, "forward", "policy_forward", spent)
    timed(model, "train", "optimiser", spent)
    start = time.perf_counter()
    while (whole := time.perf_counter() - start) < seconds:
        runs["drive"]()
    spent["rest"] = whole - sum(spent.values())
    return {
        "environments": config.n_envs,
        "rollout": config.n_steps,
        "batch": config.batch_size,
        "epochs": config.n_epochs,
        "decision_ms": config.decision_ms,
        "steps_per_s": rates,
        "drive_over_free": rates["drive"] / rates["free"],
        "share_of_time": {name: part / whole for name, part in spent.items()},
    }

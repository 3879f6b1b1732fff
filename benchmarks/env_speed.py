"""Speed of the environments: decisions of 1 ms per second, and how it changes with their number.

Every decision is five periods of a drive and five of its twin, with observation, reward terms, the
critic's quantities and new episodes.
"""

from typing import Any

import gymnasium
import numpy as np

import sensorless  # noqa: F401  (registers the environment)
from benchmarks.timing import Run, best_rates
from sensorless.agents.train.sb3_adapter import SB3VecEnv

ID = "sensorless/Blend-v0"

SIZES = (1, 4, 16, 64, 256, 1024, 4096, 16384)

SMALLEST = 4000
"""Decisions between two looks at the clock, about."""


def single() -> Run:
    """One drive through ``gymnasium.make``."""
    env = gymnasium.make(ID)
    env.reset(seed=0)
    action = np.ones(1, dtype=np.float32)

    def run() -> int:
        for _ in range(200):
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return 200

    return run


def _stepping(env: Any, n: int) -> Run:
    """Steps of an environment of n drives that was reset."""
    action = np.ones((n, 1), dtype=np.float32)
    calls = max(3, SMALLEST // n)

    def run() -> int:
        for _ in range(calls):
            env.step(action)
        return calls * n

    return run


def vector(n: int) -> Run:
    """n drives through ``gymnasium.make_vec``."""
    env = gymnasium.make_vec(ID, num_envs=n)
    env.reset(seed=0)
    return _stepping(env, n)


def adapted(n: int) -> Run:
    """n drives through the adapter of stable-baselines3, critic's columns included."""
    native: Any = gymnasium.make_vec(ID, num_envs=n, autoreset_mode="SameStep")
    env = SB3VecEnv(native, privileged=True)
    env.reset()
    return _stepping(env, n)


def measure(seconds: float) -> dict[str, Any]:
    """Decisions per second through every door, and microseconds by the number of drives."""
    doors = {"make": single(), "make_vec_64": vector(64), "sb3_64": adapted(64),
             "make_vec_1024": vector(1024), "sb3_1024": adapted(1024)}  # fmt: skip
    rates = best_rates(doors, seconds)
    growth = best_rates({str(n): vector(n) for n in SIZES}, seconds)
    return {
        "decisions_per_s": rates,
        "us_per_drive_and_decision": {n: 1e6 / rate for n, rate in growth.items()},
        "us_per_step": {n: 1e6 * int(n) / rate for n, rate in growth.items()},
    }

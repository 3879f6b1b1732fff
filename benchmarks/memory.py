"""Memory of an environment, and that it does not grow however long the drives run."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import sensorless  # noqa: F401  (registers the environment)
from sensorless.core_api import SIM

DRIVES = 16384
"""For the memory of one."""

PERIODS = 100_000_000
"""For the growth, of the drives under test; their twins run as many."""

SIDE = 1024
"""Drives that share these periods."""

DECISION = 5
"""Periods of a decision."""


def resident() -> int:
    """Bytes of this process in memory (Linux)."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) * 1024
    raise RuntimeError("no VmRSS in /proc/self/status")


def stepped(n: int) -> tuple[Any, Any]:
    """Vector environment after a reset and a step, and an action for it."""
    env = gymnasium.make_vec("sensorless/Blend-v0", num_envs=n)
    action = np.ones((n, 1), dtype=np.float32)
    env.reset(seed=0)
    env.step(action)
    return env, action


def measure() -> dict[str, Any]:
    """Bytes an environment, and bytes gained over ``PERIODS``; None where there is no /proc."""
    if not Path("/proc/self/status").exists():
        return {"sim_bytes": SIM.itemsize, "environment_bytes": None, "growth_bytes": None}
    stepped(SIDE)
    before = resident()
    many = stepped(DRIVES)
    environment = (resident() - before) / DRIVES
    del many

    env, action = stepped(SIDE)
    steps = PERIODS // (SIDE * DECISION)
    for _ in range(steps // 10):
        env.step(action)
    start = resident()
    for _ in range(steps):
        env.step(action)
    return {
        "sim_bytes": SIM.itemsize,
        "environment_bytes": environment,
        "growth_bytes": resident() - start,
        "growth_periods": PERIODS,
    }

"""Memory of an environment, and that it does not grow however long the drives run.

``measure`` starts this file as a process of its own: memory that others freed would hide what is
used.
"""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import sensorless  # noqa: F401  (registers the environment)
from benchmarks.words import parser
from sensorless.core.api import SIM
from sensorless.decision import decision_periods
from sensorless.machine.motor import Motor

DRIVES = 16384
"""For the memory of one."""

PERIODS = 100_000_000
"""For the growth, of the drives under test; their twins run as many."""

SIDE = 1024
"""Drives that share these periods."""

DECISION = decision_periods(Motor.load("paper"))
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
    """Bytes an environment, and bytes gained over ``PERIODS``; only on Linux."""
    command = (sys.executable, "-m", "benchmarks.memory")
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    out: dict[str, Any] = json.loads(done.stdout)
    return out


def main() -> None:
    """Measure and print as JSON."""
    parser(__doc__).parse_args()
    if not Path("/proc/self/status").exists():
        print(json.dumps({"sim_bytes": SIM.itemsize}))
        return
    stepped(16)
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
    result = {
        "sim_bytes": SIM.itemsize,
        "environment_bytes": environment,
        "growth_bytes": resident() - start,
        "growth_periods": PERIODS,
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()

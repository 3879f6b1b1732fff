"""Speed of the closed loop: PWM periods per second of wall time, one thread.

Every variant simulates the same: machine with all effects, inverter, sensors, both observers,
control, and the sensored twin in lock-step; a period counts once, the twin's is not counted.
``scalar`` goes drive by drive, ``batched`` runs blocks of drives as vector code, ``vector_env`` is
the Gymnasium vector environment with 64 drives including observations, rewards and resets.
``scalar_without_twin`` leaves the twin out.
"""

import json
import platform
import time
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np

import sensorless  # noqa: F401  (registers the environment)
from sensorless.core_api import SIGNAL_N, sim_run
from sensorless.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenario import Scenarios, SimFactory
from sensorless.files import write_atomic
from sensorless.motor import Motor

SECONDS = 1.5
"""Least time a variant is measured for; the best of all its chunks counts."""

CHUNK = 20_000
"""Periods between two looks at the clock, about."""


def best_rate(run: Callable[[], int]) -> float:
    """Periods per second of the fastest chunk; ``run`` does one and returns its periods."""
    run()
    rates = []
    stop = time.perf_counter() + SECONDS
    while time.perf_counter() < stop:
        start = time.perf_counter()
        periods = run()
        rates.append(periods / (time.perf_counter() - start))
    return max(rates)


def core_loop(n: int, *, twin: bool, plain: bool, periods: int) -> Callable[[], int]:
    """n drives at 350 r/min between both observers, ``periods`` a call."""
    motor = Motor.load("paper")
    s = Scenarios.nominal(motor, combine(0, np.arange(n)), 1e5)
    s.omega_0[:] = 350.0 * np.pi / 30.0
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, DriveDesign()).build(s, twin=twin)
    k_s = np.full(n, 0.5, dtype=np.float32)
    obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
    calls = max(1, CHUNK // (n * periods))

    def run() -> int:
        for _ in range(calls):
            sim_run(sims, periods, k_s, obs, plain=plain)
        if sims["lost"].any():
            raise RuntimeError("a drive got lost: the figure would be wrong")
        return calls * n * periods

    return run


def env_loop(n: int, decision: int) -> Callable[[], int]:
    """The vector environment on its default scenarios, all weight on injection."""
    env = gymnasium.make_vec("sensorless/Blend-v0", num_envs=n)
    env.reset(seed=0)
    action = np.ones((n, 1), dtype=np.float32)
    calls = max(1, CHUNK // (n * decision))

    def run() -> int:
        for _ in range(calls):
            env.step(action)
        return calls * n * decision

    return run


def main() -> None:
    """Measure, print, and write ``build/bench.json``."""
    variants = {
        "scalar": core_loop(64, twin=True, plain=True, periods=5),
        "scalar_without_twin": core_loop(64, twin=False, plain=True, periods=5),
        "batched": core_loop(64, twin=True, plain=False, periods=5),
        "vector_env": env_loop(64, 5),
    }
    rates = {}
    for name, run in variants.items():
        rates[name] = best_rate(run)
        print(f"{name:20s} {rates[name] / 1e6:7.2f} million periods/s", flush=True)
    ratios = {
        f"{name}_over_scalar": rates[name] / rates["scalar"] for name in ("batched", "vector_env")
    }
    for name, ratio in ratios.items():
        print(f"{name:25s} {ratio:.2f}")
    out = Path("build/bench.json")
    out.parent.mkdir(exist_ok=True)
    write_atomic(
        out,
        json.dumps(
            {
                "periods_per_s": rates,
                "ratios": ratios,
                "machine": platform.processor() or platform.machine(),
            },
            indent=1,
        ),
    )
    print(f"wrote {out}")


if __name__ == "__main__":
    main()

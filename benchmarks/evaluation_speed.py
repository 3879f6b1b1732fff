"""Speed of an evaluation: scenarios a second on one thread and on two."""

import os
from typing import Any

from benchmarks.timing import Run, best_rates
from sensorless.core.api import THREADS
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

SIZE = 1024
"""Scenarios of 2 s of ``stress-1``: four chunks."""


def evaluation(threads: int) -> Run:
    """Eq. 25 judged on the paper's motor."""
    motor = Motor.load("paper")
    policy, factory = make_policy("eq25", motor), SimFactory(motor, DriveDesign())
    rows = SuiteRows("stress-1", motor, 1, SIZE)

    def run() -> int:
        before = os.environ.get(THREADS)
        os.environ[THREADS] = str(threads)
        try:
            score(policy, rows, factory)
        finally:
            del os.environ[THREADS]
            if before is not None:
                os.environ[THREADS] = before
        return SIZE

    return run


def measure(seconds: float) -> dict[str, Any]:
    """Scenarios a second, and their ratio."""
    rates = best_rates({"one_thread": evaluation(1), "two_threads": evaluation(2)}, seconds)
    return {
        "scenarios_per_s": rates,
        "two_threads_over_one": rates["two_threads"] / rates["one_thread"],
    }

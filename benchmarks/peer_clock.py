"""Steps per second of a loop, printed as JSON; imports nothing but the standard library."""

import json
import platform
import time
from collections.abc import Callable
from importlib.metadata import version

SECONDS = 3.0
"""Least time a loop runs for [s]."""


def rate(run: Callable[[], int]) -> dict[str, float]:
    """Steps per second of wall time and of processor time; ``run`` returns how many it did."""
    run()
    steps, wall, cpu = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - wall < SECONDS:
        steps += run()
    return {
        "per_s": steps / (time.perf_counter() - wall),
        "per_cpu_s": steps / (time.process_time() - cpu),
    }


def tell(rates: dict[str, dict[str, float]], packages: tuple[str, ...]) -> None:
    """Print rates and versions as one line."""
    versions = {"python": platform.python_version(), **{name: version(name) for name in packages}}
    print(json.dumps({"rates": rates, "versions": versions}))

"""Many scenarios over two Ray nodes on this machine against one process, bit for bit.

Runs them in one process, on two nodes of one processor each, and again with one of the nodes killed
half way; exit status 1 if any bit differs. The scenarios are those of ``stress``, cut to a given
length so that 100,000 of them take minutes::

    python benchmarks/scale_check.py --size 100000 --duration 0.2
"""

import argparse
import os
import secrets
import sys
import time
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.named import engine_named
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.evaluate import Scores, score
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

CHUNK = 1024
"""Scenarios a task: cut to 0.2 s, they take as long as 100 of the usual length."""


def timed(what: str, scenarios: Scenarios, engine: Engine, report: Callable[[float], None]) -> Any:
    """Scores of Eq. 25, with a line about the time."""
    motor = Motor.load("paper")
    start = time.perf_counter()
    found = score(
        make_policy("eq25", motor),
        scenarios,
        SimFactory(motor, DriveDesign()),
        report,
        engine,
        CHUNK,
    )
    print(f"{what}: {time.perf_counter() - start:.1f} s", flush=True)
    return found


def same(a: Scores, b: Scores) -> bool:
    """All arrays have the same bits."""
    pairs = [(getattr(a, f.name), getattr(b, f.name)) for f in fields(Scores)]
    return all(_bits(x) == _bits(y) for x, y in pairs)


def _bits(x: Any) -> Any:
    return {k: _bits(v) for k, v in x.items()} if isinstance(x, dict) else np.asarray(x).tobytes()


def main() -> int:
    """Run the three and compare."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--size", type=int, default=100_000)
    parser.add_argument("--duration", type=float, default=0.2, help="length of a scenario [s]")
    args = parser.parse_args()
    os.environ |= {"RAY_AUTH_MODE": "token", "RAY_AUTH_TOKEN": secrets.token_hex(32)}
    from ray.cluster_utils import Cluster

    scenarios = suite("stress-1", Motor.load("paper"), 1, args.size)
    scenarios.duration[:] = args.duration
    wanted = timed("one process", scenarios, LOCAL, lambda _: None)
    print(f"lost: {100.0 * np.mean(wanted.lost != 0):.2f} % of {args.size}")
    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    second = cluster.add_node(num_cpus=1)
    killed: list[float] = []

    def kill(done: float) -> None:
        if done >= 0.5 and not killed:
            cluster.remove_node(second, allow_graceful=False)
            killed.append(done)
            print(f"killed a node at {100.0 * done:.0f} %", flush=True)

    try:
        with engine_named("ray", cluster.address) as engine:
            two = timed("two Ray nodes", scenarios, engine, lambda _: None)
            one = timed("one node killed", scenarios, engine, kill)
    finally:
        cluster.shutdown()
    equal = same(wanted, two), same(wanted, one)
    print(f"equal to the bit: two nodes {equal[0]}, one node killed {equal[1]}")
    return 0 if all(equal) else 1


if __name__ == "__main__":
    sys.exit(main())

"""Runs many drives in the browser's core and in the native one, and counts the bytes that differ.

Usage: python -m web.compare; needs Debian's clang, lld and nodejs.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from sensorless.core.api import (
    SIGNAL_N,
    SIM,
    TABLE,
    TRACE_NAMES,
    Array,
    sim_run,
    sim_signals,
)
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable
from web.wasm import compile_core

DRIVES = 64
DECISIONS = 4000
ESTIMATORS = ("smo", "coupled", "flux")
RULE = "eq25"
SCRIPT = Path(__file__).with_name("compare.mjs")


def drives(motor: Motor, estimator: str) -> Array:
    """Drives of the suite ``stress`` at their starts, without an end."""
    factory = SimFactory(motor, DriveDesign(estimator=estimator))
    sims = factory.build(suite("stress", motor, 11, DRIVES))
    sims["k_end"] = np.iinfo(np.int32).max
    return sims


def native(sims: Array, table: KsTable, periods: int) -> Array:
    """The drives after all decisions, one period after the other."""
    out = sims.copy()
    obs = np.zeros((len(out), SIGNAL_N), dtype=np.float32)
    sim_signals(out, obs)
    for _ in range(DECISIONS):
        sim_run(out, periods, table.evaluate(obs), obs, plain=True)
    return out


def in_wasm(sims: Array, table: KsTable, periods: int) -> Array:
    """The same as the page does it, by node."""
    told = {"size": SIM.itemsize, "row": 8 * len(TRACE_NAMES), "periods": periods}
    with tempfile.TemporaryDirectory() as folder:
        core, before, rule, after = (
            Path(folder, name) for name in ("core", "before", "rule", "after")
        )
        core.write_bytes(compile_core())
        before.write_bytes(sims.tobytes())
        rule.write_bytes(table.record().tobytes() + table.stored().tobytes())
        told |= {"header": TABLE.itemsize, "decisions": DECISIONS}
        files = map(str, (core, before, rule, after))
        subprocess.run(["node", str(SCRIPT), *files, json.dumps(told)], check=True)
        return np.frombuffer(after.read_bytes(), dtype=SIM)


def main() -> None:
    """Print one line an estimator; fail if a byte differs."""
    argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0]).parse_args()
    if shutil.which("node") is None:
        sys.exit("error: compare: needs nodejs; run: apt-get install nodejs")
    motor = Motor.load("paper")
    policy, periods, total = make_policy(RULE, motor), decision_periods(motor), 0
    if not isinstance(policy, TablePolicy):
        raise TypeError(f"{RULE}: not a table")
    for estimator in ESTIMATORS:
        sims = drives(motor, estimator)
        here, there = (f(sims, policy.table, periods) for f in (native, in_wasm))
        differ = int((here.view(np.uint8) != there.view(np.uint8)).sum())
        total += differ
        print(
            f"{estimator}: {differ} of {here.nbytes} bytes differ, {DRIVES} drives, "
            f"{DECISIONS * periods} periods, {int((here['lost'] != 0).sum())} lost"
        )
    sys.exit(1 if total else 0)


if __name__ == "__main__":
    main()

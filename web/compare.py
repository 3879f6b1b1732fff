"""Runs many drives in the browser's core and in the native one, and counts the bytes that differ.

Usage: python -m web.compare; needs Debian's clang, lld and nodejs.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from sensorless.core.api import SIGNAL_N, SIM, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.motor import Motor
from web.wasm import compile_core

DRIVES = 64
PERIODS = 20_000
ESTIMATORS = ("smo", "coupled", "flux")
SCRIPT = Path(__file__).with_name("compare.mjs")


def drives(estimator: str, count: int) -> Array:
    """Drives of the suite ``stress`` at their starts, without an end."""
    motor = Motor.load("paper")
    sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(
        suite("stress", motor, 11, count)
    )
    sims["k_end"] = PERIODS
    return sims


def differing(sims: Array, k_s: float) -> tuple[int, int, int]:
    """Bytes that differ after the run, bytes in all, drives that were lost."""
    wasm = json.dumps({"size": SIM.itemsize, "periods": PERIODS, "k_s": k_s})
    with tempfile.TemporaryDirectory() as folder:
        code, before, after = (Path(folder, name) for name in ("core.wasm", "before", "after"))
        code.write_bytes(compile_core())
        before.write_bytes(sims.tobytes())
        words = ["node", str(SCRIPT), str(code), str(before), str(after), wasm]
        subprocess.run(words, check=True)
        there = np.frombuffer(after.read_bytes(), dtype=np.uint8)
    here = sims.copy()
    weights = np.full(len(here), k_s, dtype=np.float32)
    sim_run(here, PERIODS, weights, np.zeros((len(here), SIGNAL_N), np.float32), plain=True)
    bytes_here = here.view(np.uint8).reshape(-1)
    return int((bytes_here != there).sum()), len(bytes_here), int((here["lost"] != 0).sum())


def main() -> None:
    """Print one line an estimator; fail if a byte differs."""
    if shutil.which("node") is None:
        sys.exit("error: compare: needs nodejs; run: apt-get install nodejs")
    total = 0
    for estimator in ESTIMATORS:
        count, size, lost = differing(drives(estimator, DRIVES), 0.5)
        total += count
        print(
            f"{estimator}: {count} of {size} bytes differ, {DRIVES} drives, {PERIODS} periods, "
            f"{lost} lost"
        )
    sys.exit(1 if total else 0)


if __name__ == "__main__":
    main()

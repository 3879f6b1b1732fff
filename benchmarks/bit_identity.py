"""Bit identity over a million closed-loop control periods: every compiler, level and machine.

Usage: python benchmarks/bit_identity.py [PERIODS], writes build/bit_identity.json
"""

import argparse
import dataclasses
import json
import sys
from pathlib import Path

import numpy as np

from sensorless.core.api import ffi, lib
from sensorless.design.drive import DriveDesign
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.pil.identity import identity
from sensorless.table.ks_table import Axis, KsTable


def bumpy_table() -> KsTable:
    """Eq. 25 with bumps over the torque current, so that both axes matter."""
    axes = (Axis("speed", 0.0, 0.5, 9), Axis("torque_current", -1.5, 1.5, 5))
    ramp = np.clip((0.27 - axes[0].nodes[:, None]) / 0.07, 0.0, 1.0)
    bumps = 0.1 * np.random.default_rng(5).standard_normal((9, 5))
    values = np.clip(ramp + np.where((ramp > 0) & (ramp < 1), bumps, 0.0), 0.0, 1.0)
    return KsTable(axes, values.astype(np.float32))


def main() -> int:
    """Run and report; status 1 if a word differs."""
    words = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    words.add_argument("periods", nargs="?", type=int, default=1_000_000, help="PWM periods")
    periods = int(words.parse_args().periods)
    rows = []
    for x in identity(bumpy_table(), Motor.load("paper"), DriveDesign(), periods):
        c = x.configuration
        against = "plain" if c.plain else "vector"
        what = f"{c.machine:7}{c.compiler:6} {c.level:4} against the host's {against:6} code"
        found = f"{x.periods:9,} periods, {x.mismatches} words differ, {x.seconds:.0f} s"
        print(f"{what}: {found}", flush=True)
        rows.append(dataclasses.asdict(x))
    out = Path("build/bit_identity.json")
    out.parent.mkdir(exist_ok=True)
    core = ffi.string(lib.core_hash).decode()
    write_atomic(out, json.dumps({"core_hash": core, "rows": rows}, indent=2) + "\n")
    print(f"wrote {out}")
    return int(any(row["mismatches"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())

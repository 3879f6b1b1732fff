"""Bit identity over a million closed-loop control periods: every compiler, level and machine.

Usage: python benchmarks/bit_identity.py [PERIODS], writes build/bit_identity.json
"""

import argparse
import dataclasses
import json
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sensorless.core.api import ffi, lib
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.export.export import export
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.pil.device import DRIVES, Device
from sensorless.pil.lockstep import lockstep
from sensorless.pil.scenarios import pil_scenarios
from sensorless.pil.tools import build, qemu_command
from sensorless.table.ks_table import Axis, KsTable


@dataclass(frozen=True)
class Configuration:
    """One way to compile and run the exported core, to compare with the extension on the host."""

    machine: str
    """``target`` or ``host``"""
    level: str
    compiler: str = "gcc"
    plain: bool = False
    """The extension runs drive by drive instead of in blocks of vector code."""


LEVELS = ("-O0", "-O2", "-O3", "-Os")
ALL = (
    *(Configuration("target", level) for level in LEVELS),
    *(Configuration("host", level) for level in LEVELS),
    *(Configuration("host", level, "clang") for level in ("-O0", "-O2", "-O3")),
    Configuration("host", "-O2", plain=True),
)


@dataclass(frozen=True)
class Outcome:
    """Result of one configuration."""

    configuration: Configuration
    periods: int
    mismatches: int
    seconds: float


def identity(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    periods: int,
    configurations: Sequence[Configuration] = ALL,
    drives: int = DRIVES,
) -> Iterator[Outcome]:
    """Compare every word of at least ``periods`` closed-loop control periods per configuration.

    Configurations whose compiler is not installed are left out.

    Parameters
    ----------
    table, motor, design
        As for ``export``.
    periods : int
    configurations : sequence of Configuration
    drives : int
        Scenarios at a time.
    """
    with tempfile.TemporaryDirectory(prefix="sensorless-identity-") as temp:
        place = Path(temp)
        export(table, motor, design, place / "export")
        built: dict[tuple[str, str, str], Path] = {}
        for c in configurations:
            if c.machine == "host" and shutil.which(c.compiler) is None:
                continue
            began = time.monotonic()
            same = (c.machine, c.level, c.compiler)
            if same not in built:
                what = "image" if c.machine == "target" else "host"
                folder = place / f"build{len(built)}"
                built[same] = build(place / "export", folder, what, c.level, c.compiler)
            program = built[same]
            command = qemu_command(program) if c.machine == "target" else [str(program)]
            done, wrong, seed = 0, 0, 100
            with Device(command, place if c.machine == "target" else None) as device:
                while done < periods:
                    sims = SimFactory(motor, design).build(pil_scenarios(motor, seed, drives)[1])
                    sims["k_end"] = sims["k_end"].clip(max=-(-periods // drives))
                    run = lockstep(device, sims, table, decision_periods(motor), plain=c.plain)
                    done += int(run.periods.sum())
                    wrong += int(run.mismatches.sum())
                    seed += 1
            yield Outcome(c, done, wrong, time.monotonic() - began)


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

"""Compares the control core bit by bit between compilers, optimisation levels and processors."""

import shutil
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.export.export import export
from sensorless.machine.motor import Motor
from sensorless.pil.device import DRIVES, Device
from sensorless.pil.lockstep import lockstep
from sensorless.pil.scenarios import pil_scenarios
from sensorless.pil.tools import build, qemu_command
from sensorless.table.ks_table import KsTable


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

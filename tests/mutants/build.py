"""Parameters, compiler call and run of the checks that a mutant has to pass."""

import os
import subprocess
from pathlib import Path

from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.design.records import control_record
from sensorless.export.code import initialiser
from sensorless.machine.motor import Motor

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
DRIVE = ROOT / "core" / "drive"
FLAGS = "-std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math -D_GNU_SOURCE".split()
QUICK = "-DCORE_INLINE=static inline"
"""Calls instead of copies, which the compiler is a quarter faster with."""
SUM = "sum "
OBJECTS = ("drive", "drive_check", "drive_lock", "drive_start", "ks_schedule", "ks_table")
"""Files of the core that the checks call."""


def write_params(folder: Path) -> None:
    """Write ``params.h``: the paper's machine, one drive for each estimator."""
    motor = Motor.load("paper")
    names = sorted(ESTIMATORS, key=lambda name: ESTIMATORS[name])
    drives = [
        initialiser(control_record(motor, DriveDesign(estimator=name)), "drive_params_t")
        for name in names
    ]
    text = "#pragma once\nstatic const drive_params_t PARAMS[] = {" + ",\n".join(drives) + "};\n"
    (folder / "params.h").write_text(text)


def sources(drive: Path, folder: Path) -> list[Path]:
    """What is compiled against the core in ``drive``; the checks as one file in ``folder``.

    Each by itself would read the headers again, which takes longer than what it adds to them.
    """
    checks = folder / "all_checks.c"
    checks.write_text("".join(f'#include "{path.name}"\n' for path in sorted(HERE.glob("*.c"))))
    core = [drive / f"{name}.c" for name in OBJECTS]
    return [*core, checks, ROOT / "firmware" / "faults.c"]


def compile_checks(drive: Path, folder: Path) -> Path | None:
    """Program of the checks in ``folder``, beside ``params.h``; None if it does not compile."""
    program = folder / "checks"
    compiler = os.environ.get("CC", "cc").split()
    for name in ("core", "test"):
        (folder / name).mkdir(exist_ok=True)
    for name in ("drive.h", "ks_schedule.h"):  # as the shipped fault tests include it
        (folder / "core" / name).write_text(f"#include <{name}>\n")
    include = [f"-I{drive}", f"-I{folder}", f"-I{HERE}", f"-I{ROOT / 'firmware'}"]
    command = [*compiler, *FLAGS, QUICK, "-O0", "-w", *include, f"-I{folder / 'test'}",
               *map(str, sources(drive, folder)), "-lm", "-o", str(program)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, check=False)
    return None if done.returncode else program


def run_checks(program: Path, expected: str = "0", limit: float = 20.0) -> tuple[list[str], str]:
    """Failed checks, and the trajectory's sum; a crash or a hang is a failed check."""
    try:
        done = subprocess.run(
            [str(program), expected], capture_output=True, text=True, timeout=limit, check=False
        )
    except subprocess.TimeoutExpired:
        return ["hangs"], ""
    lines = done.stdout.splitlines()
    found = [line for line in lines if line.startswith(SUM)]
    failed = [line for line in lines if not line.startswith(SUM)]
    if not found:
        return [*failed, f"ends with status {done.returncode}"], ""
    return failed, found[0].removeprefix(SUM)

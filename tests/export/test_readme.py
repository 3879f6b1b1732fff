"""What the README tells an integrator is what the core and the machine have."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from sensorless.core.api import enumeration, ffi, lib, pointer
from sensorless.design.drive import DriveDesign
from sensorless.design.records import bring_up_record, control_record
from sensorless.export.core_files import core_files
from sensorless.export.export import Exported
from sensorless.export.faults import DO, bits, fault_tables
from sensorless.export.hook import hook_text
from sensorless.export.readme import readme
from sensorless.export.start import CHANGES, GUESSES, LOST, lost_text
from sensorless.machine.motor import Motor
from sensorless.observers.lock_design import ACTIONS
from sensorless.table.ks_table import KsTable


def test_every_bit_of_the_core_is_in_a_table_and_says_what_to_do() -> None:
    """A new bit needs its words in ``sensorless/export/faults.py``."""
    compiled = {
        f"{head}{name.upper()}": bit
        for head in ("FAULT_", "KS_FAULT_", "BRING_UP_FAULT_")
        for name, bit in enumeration(head).items()
        if name != "all"
    }
    assert {b.name: b.value for b in bits()} == compiled
    assert set(compiled) <= set(DO)
    assert all(b.meaning for b in bits())
    tables = fault_tables()
    assert sum(rows.count("\n") + 1 for rows in tables.values()) == len(compiled)
    for rows in tables.values():
        values = [int(row.split()[1]) for row in rows.splitlines()]
        assert values == sorted(values)


@pytest.mark.parametrize("share", [1.0, 0.1])
def test_only_what_the_check_judges_is_promised(share: float, motor: Motor, table: KsTable) -> None:
    """A tenth of the dead time hides behind thresholds."""
    less = replace(motor, dead_time=share * motor.dead_time)
    drive = control_record(less, DriveDesign())
    said = readme(table, less, drive, 0.1, "policy", "smo", 1, (1, 1), ("", "", ""))
    bit = "| 256 | `BRING_UP_FAULT_DEAD_TIME` |" in said
    assert bit == ("and dead time are right" in said) == (share == 1.0)
    assert ("dead time is not judged, because its" in said) == (share < 1.0)
    assert f"for a dead time of {1e9 * less.dead_time:.6g} ns at the gates" in said


def test_an_export_that_leaves_dead_time_to_the_driver_does_not_judge_it(
    motor: Motor, table: KsTable
) -> None:
    """Its own bit would ask for what has just been done."""
    drive = control_record(motor, DriveDesign(dead_time_share=0.0))
    said = readme(table, motor, drive, 0.1, "policy", "smo", 1, (1, 1), ("", "", ""))
    assert "BRING_UP_FAULT_DEAD_TIME" not in said and "drive_step` adds up" not in said
    assert "dead time is not judged, because this export leaves it to the driver" in said
    assert bring_up_record(motor, compensates=False)["u_lost"] == 0.0
    assert bring_up_record(motor)["u_lost"] > 0.0


@pytest.mark.parametrize("name", ACTIONS)
def test_what_a_drive_does_that_lost_its_rotor(name: str) -> None:
    """A machine without saturation cannot seek its pole at rest: only a restart has to guess."""
    restarts = name == "restart"
    for motor, observer, guesses, changes in (
        ("pmsyrm_5600w", "coupled", False, False),
        ("ebike_hub", "smo", restarts, restarts),
    ):
        said = lost_text(ACTIONS[name], Motor.load(motor), observer)
        assert f"lost_lock={name}" in said and LOST[name] in said
        assert ((GUESSES in said), (CHANGES in said)) == (guesses, changes)


def test_a_bit_is_read_from_its_header(monkeypatch: pytest.MonkeyPatch) -> None:
    header = b"enum { FAULT_NEW = 64, /* something\n * else */ OTHER = 1 };"
    monkeypatch.setattr("sensorless.export.faults.core_files", lambda _: {"x.h": header})
    assert fault_tables()["drive"] == "| 64 | `FAULT_NEW` | something else |  |"


def test_the_order_is_that_of_the_questions(exported: Exported, motor: Motor) -> None:
    said = (exported.folder / "README.md").read_text(encoding="utf-8")
    asked = (
        "The calls", "When to sample", "Carrier", "Signs", "delay", "Dead time", "Over-current",
        "integrated correctly", "Start", "estimator leads", "wrong", "Only the schedule",
    )  # fmt: skip
    headings = re.findall(r"^## (.*)$", said, re.MULTILINE)
    found = [next(j for j, h in enumerate(headings) if word in h) for word in asked]
    assert found == sorted(found)
    most = min(motor.i_trip, 0.98 * motor.adc_range)
    assert f"`FAULT_OVER_CURRENT` beyond {most:.4g} A" in said
    assert f"({motor.i_trip:g} A, peak)" in said and f"`MOTOR_POLE_PAIRS` ({motor.n_p})" in said
    assert "$" not in said and "lost_lock=report" in said
    for name in re.findall(r"`core/([\w.]+)`", said):
        assert name in core_files()


def test_the_makefile_builds_the_foreign_drive(copied: Path, table: KsTable) -> None:
    if shutil.which("gcc") is None:
        pytest.skip("needs gcc")
    done = subprocess.run(
        ["make", "example", "CC=gcc", "CFLAGS=-O1"],
        cwd=copied, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and not done.stderr, done.stderr
    rows = re.findall(r"of rated: k_s (\S+), Q15 +(\d+), angle (\S+) rad", done.stdout)
    k_s = [float(row[0]) for row in rows]
    assert k_s[0] == 1.0 and k_s[-1] == 0.0 and any(0.0 < x < 1.0 for x in k_s)
    for weight, word, angle in rows:
        assert abs(float(word) / 32767.0 - float(weight)) < 2e-3
        assert float(angle) == pytest.approx(0.3 + 0.05 * float(weight), abs=2e-3)
    assert "example/foreign_drive.c" in hook_text(table)


@pytest.mark.usefixtures("target")
def test_the_makefile_compiles_the_cortex_m4(copied: Path) -> None:
    """Without a warning; all that is left open is what any start-up file brings along."""
    done = subprocess.run(
        ["make", "cortex_m4", "CFLAGS=-O0"], cwd=copied, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and not done.stderr, done.stderr
    symbols = subprocess.run(
        ["arm-none-eabi-nm", "build/cortex_m4.o"], cwd=copied, capture_output=True, text=True,
        check=True,
    ).stdout  # fmt: skip
    assert set(re.findall(r" U (\w+)", symbols)) <= {"memcpy", "memset"}
    assert {"main", "adc_interrupt"} <= set(re.findall(r" T (\w+)", symbols))


def test_the_lines_of_the_check_compile_in_their_order(exported: Exported, tmp_path: Path) -> None:
    """The state begins before the first step: one of zeros is done, and finds no fault."""
    if shutil.which("gcc") is None:
        pytest.skip("needs gcc")
    said = (exported.folder / "README.md").read_text(encoding="utf-8")
    lines = [line for line in said.splitlines() if line.startswith("    ") and "check;" in line]
    lines += re.findall(r"^    .*bring_up_\w+\(.*$", said, re.MULTILINE)
    assert [re.findall(r"bring_up_(\w+)", line)[0] for line in lines] == ["state_t", "init", "step"]
    body = "\n".join(["float i_a = 0, i_b = 0;", *lines, "return (int)u.a;"])
    source = tmp_path / "check.c"
    source.write_text(f'#include "params.h"\nint main(void) {{\n{body}\n}}\n')
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{exported.folder}"]
    subprocess.run(["gcc", *flags, source], check=True)


def test_a_stopped_drive_whose_bit_was_cleared_stays_stopped(
    motor: Motor, exported: Exported
) -> None:
    """And says so again: only ``drive_init`` ends it, and the search for the rotor does not."""
    control = pointer(control_record(motor, DriveDesign()).reshape(1), "drive_params_t[]")
    x, rest = ffi.new("drive_state_t *"), ffi.new("drive_in_t *", [0.0, 0.0, motor.u_dc, 9.0, 1.0])
    lib.drive_init(control, x, 0.0, 0.0, 1.0)
    lib.drive_trip(x)
    x.fault = 0
    for _ in range(200):
        u = lib.drive_step(control, x, rest)
        assert (u.a, u.b) == (0.0, 0.0)
    assert x.fault == lib.FAULT_STOPPED | lib.FAULT_OVER_CURRENT
    lib.drive_find_rotor(x)
    assert lib.drive_step(control, x, rest).a == 0.0
    assert x.fault & ~lib.FAULT_OVER_CURRENT == lib.FAULT_STOPPED | lib.FAULT_COMMAND
    blank = ffi.new("drive_state_t *")
    lib.drive_find_rotor(blank)  # before drive_init
    assert blank.fault == lib.FAULT_COMMAND
    said = (exported.folder / "README.md").read_text(encoding="utf-8")
    assert "`FAULT_STOPPED` to `drive_init`: cleared by hand it is back in the next period" in said

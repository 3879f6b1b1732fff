"""A damaged table in flash is told by its tests; nothing is looked up in it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.export.export import Exported
from tests.export.conftest import Make, selftest

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

DAMAGED_HEADER = """
#include "core/ks_selftest.h"
#include "ks_table_data.h"
#if KS_TABLE_GAINS
#include "core/gain_selftest.h"
static int told(const ks_table_t *t) {
    uint32_t first;
    return gain_table_selftest(&gain_table_f32, t, ks_values_f32, gain_values_f32,
                               gain_vectors_f32, KS_GAIN_VECTORS_F32, &first) != 0;
}
#else
static int told(const ks_table_t *t) {
    uint32_t first;
    return ks_table_selftest(t, ks_values_f32, ks_vectors_f32, KS_VECTORS_F32, &first) != 0;
}
#endif
int main(void) {
    int untold = told(&ks_table_f32);
    for (unsigned bit = 0; bit < 8 * sizeof ks_table_f32; bit++) {
        ks_table_t t = ks_table_f32;
        unsigned char *byte = (unsigned char *)&t + bit / 8;
        *byte = (unsigned char)(*byte ^ 1U << bit % 8);
        untold += !told(&t);
    }
    return untold;
}
"""
"""Every bit of a table's header flipped, one at a time; none may be read beyond its memory."""

DAMAGED_COUNTS = """
#include <limits.h>
#include "core/drive.h"
#include "params.h"
int main(void) {
    drive_in_t in = {0.1f, -0.05f, 540.0f, 10.0f, 0.5f};
    for (int j = 0; j < 400; j++) {
        static drive_state_t x;
        int32_t *counts[] = {&x.lock.wait, &x.lock.bad, &x.lock.calm, &x.lock.alarms,
                             &x.lock.restarts, &x.start.n, &x.start.tries};
        drive_init(&drive_params, &x, 0.0f, 20.0f, 1.0f);
        if (j % 2) {
            drive_find_rotor(&x);
        }
        for (int k = 0; k < j; k++) {
            drive_step(&drive_params, &x, &in);
        }
        *counts[j % 7] = j % 3 ? INT_MAX : INT_MIN;
        for (int k = 0; k < 40; k++) {
            drive_step(&drive_params, &x, &in);
        }
    }
    return 0;
}
"""
"""Counts at the ends of their range, which the drive finds after it has counted."""


def sanitized(folder: Path, text: str) -> int:
    """Exit status of a program in an exported folder, built with both sanitizers."""
    (folder / "t.c").write_text(text)
    core = [str(path) for path in sorted((folder / "core").glob("*.c"))]
    flags = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover", "-I."]
    built = [*flags, "-o", "t", "t.c", "ks_table_data.c", "params.c", *core, "-lm"]
    subprocess.run(["gcc", *built], cwd=folder, check=True)
    return subprocess.run([folder / "t"], check=False).returncode


def test_a_damaged_header_is_told_at_every_start(made: Make, tmp_path: Path) -> None:
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    assert sanitized(copied, DAMAGED_HEADER) == 0


def test_a_damaged_header_is_told_where_gains_are_set(with_gains: Exported, tmp_path: Path) -> None:
    copied = shutil.copytree(with_gains.folder, tmp_path / "copy")
    assert sanitized(copied, DAMAGED_HEADER) == 0


def test_a_damaged_count_overflows_nothing(made: Make, tmp_path: Path) -> None:
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    assert sanitized(copied, DAMAGED_COUNTS) == 0


def test_a_line_that_is_missing_in_a_table_ends_in_a_reason(made: Make, tmp_path: Path) -> None:
    """Nothing is looked up in a table that was refused."""
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    path = copied / "ks_table_data.c"
    text = path.read_text()
    path.write_text("\n".join(line for line in text.splitlines() if ".kind" not in line) + "\n")
    assert path.read_text() != text
    done = selftest(copied, "CC=gcc", "CFLAGS=-O0")
    assert "self test FAILED: float table: check: wrong CRC" in done.stderr
    assert "signals" in done.stderr.rpartition("self test FAILED")[2], "to its end"

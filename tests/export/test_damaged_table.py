"""A damaged table in flash is told by its tests; nothing is looked up in it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.export.conftest import Make, selftest

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

DAMAGED_HEADER = """
#include <string.h>
#include "core/ks_selftest.h"
#include "ks_table_data.h"
int main(void) {
    int untold = 0;
    for (unsigned bit = 0; bit < 8 * sizeof ks_table_f32; bit++) {
        ks_table_t t = ks_table_f32;
        unsigned char *byte = (unsigned char *)&t + bit / 8;
        uint32_t first;
        *byte = (unsigned char)(*byte ^ 1U << bit % 8);
        untold += ks_table_selftest(&t, ks_values_f32, ks_vectors_f32, KS_VECTORS_F32, &first) == 0;
    }
    return untold;
}
"""
"""Every bit of a table's header flipped, one at a time; none may be read beyond its memory."""


def test_a_damaged_header_is_told_at_every_start(made: Make, tmp_path: Path) -> None:
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    (copied / "t.c").write_text(DAMAGED_HEADER)
    core = [str(path) for path in sorted((copied / "core").glob("*.c"))]
    flags = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover", "-I."]
    built = [*flags, "-o", "t", "t.c", "ks_table_data.c", *core, "-lm"]
    subprocess.run(["gcc", *built], cwd=copied, check=True)
    assert subprocess.run([copied / "t"], check=False).returncode == 0


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

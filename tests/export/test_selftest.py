"""The exported folder checks itself with a C compiler alone."""

import platform
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.export import selftest as selftest_module
from sensorless.export.core_files import FIRMWARE
from sensorless.export.export import Exported, export
from sensorless.export.vectors import drive_vectors
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable
from tests.export.conftest import SANITIZERS, Make, selftest

GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


@GCC
def test_the_self_test_ran_on_export(exported: Exported) -> None:
    assert exported.self_test.ran
    assert re.fullmatch(r"self test passed: \d{4} vectors", exported.self_test.message)


@pytest.mark.parametrize("level", ["-O0", "-O2", "-O3"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_make_selftest_passes_without_a_warning(compiler: str, level: str, made: Make) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler}: not found")
    done = made(compiler, level).done
    assert done.returncode == 0 and not done.stderr, done.stderr
    assert "self test passed" in done.stdout


def test_sanitizers_find_nothing(copied: Path, watched: list[Path]) -> None:
    """With the objects of the core that the fuzzer has, too."""
    (copied / "build" / "core").mkdir(parents=True)
    for path in watched:
        shutil.copy(path, copied / "build" / "core")
    done = selftest(copied, "CC=clang", f"CFLAGS={' '.join(SANITIZERS)}")
    assert done.returncode == 0, done.stderr


def edit(path: Path, pattern: str, change: Callable[[str], str], which: int = 0) -> None:
    """Change one match of a pattern's group 1 by hand."""
    text = path.read_text()
    match = list(re.finditer(pattern, text, re.MULTILINE))[which]
    path.write_text(text[: match.start(1)] + change(match[1]) + text[match.end(1) :])


def other_word(word: str) -> str:
    return f"0x{int(word, 16) ^ 1 << 22:08X}"


def damaged(text: str) -> str:
    """Another value in place of one that an edit has found."""
    if text == "<":
        return ">"
    if text.startswith("0x"):
        return other_word(text)
    return "0.4" if text.startswith("0.") else {"32767": "32766"}.get(text, f"0.999f * {text}")


CORRUPTIONS = {
    "golden vectors": [
        ("ks_table_data.c", r"\}, (0x\w+)\},$", 20, "float table: lookups .*: 1, first 20"),
        ("ks_table_q15.c", r"\{\{(0x3\w+), 0x\w+\}", 30, "Q15 table: lookups .*: 1, first "),
        ("test/drive_vectors.h", r"(0x\w+)\},$", 4000, "control core: periods .*: 1, first 4000"),
        ("cmsis/ks_table_cmsis.c", r"^    .*?(0\.\d+)f, ", 0, "CMSIS table: lookups"),
    ],
    "values": [
        ("ks_table_data.c", r"^    (0\.\d+)f", 0, "float table: check: wrong CRC"),
        ("ks_table_q15.c", r"^    32767, (32767),", 0, "Q15 table: check: wrong CRC"),
    ],
    "an input": [
        ("test/drive_vectors.h", r"^    \{(0x\w+), ", 4400, "control core: periods .*: 600, first"),
        ("cmsis/ks_table_cmsis.h", r"\? low : (last);", 0, "CMSIS table: lookups"),
    ],
    "a checksum": [
        ("ks_table_data.c", r"\.crc_header = (0x\w+)UL", 0, "float table: check: wrong CRC")
    ],
    "a gain": [("params.c", r"\.k_p_speed = (0\.\d+)f", 0, "control core: periods .* golden")],
    "the motor": [
        ("params.h", r"MOTOR_HASH (0x\w+)UL", 0, "float table: check: made for another motor")
    ],
    "the lookup": [("core/ks_lookup.h", r"\*f = (pos) - ", 0, "float table: lookups")],
    "a start": [
        ("core/drive_start.c", r"int south = s->i_pole \* p->start.i_pole (<) 0", 0, "control core")
    ],
    "a constant": [("core/control.h", r"rot_turn\(r, (1\.5)f", 0, "control core: periods")],
}
"""File, pattern, which match, what the self test then says; together where none hides another."""


@GCC
@pytest.mark.parametrize("edits", CORRUPTIONS.values(), ids=CORRUPTIONS)
def test_a_folder_corrupted_by_hand_fails(
    made: Make, tmp_path: Path, edits: list[tuple[str, str, int, str]]
) -> None:
    """``make`` compiles again what an edit touches."""
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    for file, pattern, which, _ in edits:
        edit(copied / file, pattern, damaged, which)
    done = selftest(copied, "CC=gcc", "CFLAGS=-O0")
    assert done.returncode != 0 and "self test passed" not in done.stdout
    for file, *_, message in edits:
        assert re.search(f"self test FAILED: {message}", done.stderr), done.stderr
        assert f"{file}: FAILED\n" in done.stdout  # the reason, where the message tells its effect


@GCC
def test_the_self_test_runs_without_make_as_the_readme_says(
    exported: Exported, tmp_path: Path
) -> None:
    """In a folder whose name has a space; with the table for CMSIS-DSP, where there is one."""
    folder = shutil.copytree(exported.folder, tmp_path / "a folder")
    said = (folder / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"^    (cc .*|\./selftest)$", said, re.MULTILINE)
    assert len(lines) == 2 and ("cmsis/*.c" in lines[0]) is (folder / "cmsis").exists()
    script = " && ".join(lines).replace("cc ", "gcc ", 1).replace("-O2", "-O0")
    done = subprocess.run(
        ["sh", "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0 and "self test passed" in done.stdout, done.stderr


@GCC
def test_a_limit_that_no_vector_sees_is_named_if_edited(made: Make, tmp_path: Path) -> None:
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    before = selftest(copied, "CC=gcc", "CFLAGS=-O0")
    edit(copied / "params.c", r"u_dc_min = ([\d.]+f)", lambda _: "1.0f")
    after = selftest(copied, "CC=gcc", "CFLAGS=-O0")
    assert "note" not in before.stdout
    assert after.returncode == 0 and "params.c: FAILED\nnote: not as exported" in after.stdout


@GCC
def test_a_list_of_sums_that_lacks_a_file_is_no_proof(made: Make, tmp_path: Path) -> None:
    copied = shutil.copytree(made("gcc", "-O0").folder, tmp_path / "copy")
    sums = copied / "SHA256SUMS"
    sums.write_text("".join(sums.read_text().splitlines(keepends=True)[:1]))
    assert "note: not as exported" in selftest(copied, "CC=gcc", "CFLAGS=-O0").stdout


@pytest.mark.parametrize("words", [("CC=gcc", "-Ofast"), ("CC=clang", "-O2 -ffast-math")])
def test_fast_math_is_named_with_all_warnings_on(copied: Path, words: tuple[str, str]) -> None:
    compiler, flags = words
    if shutil.which(compiler[3:]) is None:
        pytest.skip(f"{compiler}: not found")
    done = selftest(copied, compiler, f"CFLAGS={flags}")
    assert done.returncode != 0
    assert "arithmetic: compiled with -ffast-math; leave it out" in done.stderr


@pytest.mark.usefixtures("whole_run")
def test_the_golden_run_crosses_over_both_ways(
    table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    words = drive_vectors(table, motor, design, 5).words
    k_s_ref, theta = words[:, 4].view(np.float32), words[:, 7].view(np.float32)
    assert k_s_ref[0] == k_s_ref[-1] == 1.0 and k_s_ref.min() == 0.0
    assert np.abs(np.diff(theta)).max() > 6.0  # the seam at +-pi is passed


def test_without_a_compiler_the_export_says_so(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    done = export(table, motor, design, tmp_path / "out")
    assert not done.self_test.ran
    assert done.self_test.message.startswith("self test not run, because there is no C compiler")


@GCC
@pytest.mark.parametrize(
    ("compiler", "message"),
    [
        ("gcc -ffast-math", "arithmetic: compiled with -ffast-math; leave it out"),
        ("gcc -no-such-flag", "error: .*no-such-flag"),
        ("gcc -r -nostdlib", "does not run here .*: set CC to this computer's own compiler"),
    ],
)
def test_an_export_that_fails_its_self_test_is_not_written(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    compiler: str,
    message: str,
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
) -> None:
    monkeypatch.setenv("CC", compiler)
    with pytest.raises(UserError, match=message):
        export(table, motor, design, tmp_path / "out")
    assert not list(tmp_path.iterdir())


HAS_FMA = "fma" in Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else False


@GCC
@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ("-std=gnu99", None),
        ("-ffinite-math-only", "comparisons take a NaN for a number"),
        ("-fassociative-math -fno-signed-zeros", "sums are computed wider .* or in another order"),
        pytest.param(
            "-mfma -ffp-contract=fast",
            "products and sums are fused; compile with -ffp-contract=off",
            marks=pytest.mark.skipif(not HAS_FMA, reason="needs a processor with FMA"),
        ),
        pytest.param(
            "-mfpmath=387",
            "sums are computed wider .*",
            marks=pytest.mark.skipif(platform.machine() != "x86_64", reason="needs an x86"),
        ),
    ],
)
def test_the_self_test_names_what_is_wrong_with_the_arithmetic(
    flags: str, message: str | None, tmp_path: Path
) -> None:
    """Each flag alone, after those of the Makefile; the check needs no other file."""
    test = tmp_path / "main.c"
    test.write_text(
        '#include <stdio.h>\n#include "arithmetic.h"\n'
        "int main(void) { const char *f = arithmetic_fault(); return f ? puts(f), 1 : 0; }\n"
    )
    source = str(FIRMWARE / "arithmetic.c")
    words = [*selftest_module.FLAGS, "-O2", f"-I{FIRMWARE}", *flags.split(), str(test), source]
    subprocess.run(["gcc", *words, "-o", str(tmp_path / "main")], check=True)
    done = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=False)
    assert (done.returncode == 1) is (message is not None), done.stdout
    assert message is None or re.match(message, done.stdout)


@pytest.mark.usefixtures("whole_run")
def test_a_drive_that_gets_lost_still_gives_vectors(
    tmp_path: Path, motor: Motor, design: DriveDesign
) -> None:
    smo = KsTable((Axis("speed", 0.0, 1.0, 2),), np.zeros(2, dtype=np.float32))
    assert export(smo, motor, design, tmp_path / "out").files


@pytest.mark.parametrize("n_axes", [1, 3, 4])
@GCC
def test_other_shapes_pass_too(
    tmp_path: Path, n_axes: int, motor: Motor, design: DriveDesign
) -> None:
    names = ("speed", "torque_current", "emf", "voltage")[:n_axes]
    axes = tuple(Axis(name, 0.0, 0.4, 2 + j) for j, name in enumerate(names))
    values = np.random.default_rng(6).random(tuple(a.n for a in axes), dtype=np.float32)
    assert export(KsTable(axes, values), motor, design, tmp_path / "out").self_test.ran


@GCC
def test_a_compiler_without_a_folder_for_its_files(
    tmp_path: Path, motor: Motor, design: DriveDesign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python then takes another one, the compiler none."""
    monkeypatch.setenv("TMPDIR", "/proc")
    monkeypatch.setenv("CC", "gcc")
    table = KsTable((Axis("speed", 0.0, 1.0, 2),), np.ones(2, dtype=np.float32))
    with pytest.raises(UserError, match=r"temporary file .*\(TMPDIR sets another folder\)"):
        export(table, motor, design, tmp_path / "out")
    assert not (tmp_path / "out").exists()

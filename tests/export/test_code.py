"""The C text of an export: complete, portable and exact to the bit."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.errors import UserError
from sensorless.export.code import c_float
from sensorless.export.core_files import core_files
from sensorless.export.export import Exported
from sensorless.machine.motor import Motor
from tests.export.conftest import Make

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")
GCC = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")


def test_the_core_is_the_simulated_one(exported: Exported) -> None:
    for name, content in core_files().items():
        assert (exported.folder / "core" / name).read_bytes() == content
    shipped = {p.name for p in (exported.folder / "core").iterdir()}
    assert shipped == set(core_files())
    assert not shipped & {"plant.h", "simulate.h", "simulate.c", "noise.h", "inverter.h"}


def test_target_files_use_no_library_and_no_8_bit_types(exported: Exported) -> None:
    for path in [*exported.folder.glob("*.[ch]"), *exported.folder.glob("core/*")]:
        code = re.sub(r"/\*.*?\*/", "", path.read_text(), flags=re.DOTALL)
        assert set(re.findall(r"#include <(.*?)>", code)) <= {"stdint.h"}
        assert not re.search(r"\b(u?int(_least|_fast)?8_t|char|double|malloc|goto)\b", code), path


@GCC
def test_objects_need_nothing_from_outside(made: Make, tmp_path: Path) -> None:
    folder = made("gcc", "-O2").folder
    files = [*(folder / "build" / "core").glob("*.o"), *folder.glob("*.c")]
    words = ["gcc", *FLAGS, "-r", "-nostdlib", "-o", str(tmp_path / "all.o")]
    subprocess.run([*words, *map(str, files)], check=True)
    command = ["nm", "--format=sysv", str(tmp_path / "all.o")]  # with the section of each symbol
    symbols = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "*UND*" not in symbols.stdout and "drive_step " in symbols.stdout
    # Nothing variable outside of the caller's; pointers are constant once they are relocated.
    assert not re.search(r"\.bss|\.data(?!\.rel\.ro)|\*COM\*", symbols.stdout)


@GCC
def test_the_readme_example_compiles(exported: Exported, tmp_path: Path) -> None:
    readme = (exported.folder / "README.md").read_text()
    isr, check = re.findall(r"```c\n(.*?)```", readme, re.DOTALL)
    stubs = """
float adc_current_a(void); float adc_current_b(void); float adc_dc_link(void);
float speed_reference(void); void pwm_set_next(ab_t u, float u_dc); void report(int a, int b);
void bridge_off(void);
void control_start(void); void control_isr(void); uint32_t check(void);
"""
    head, rest = isr.split("\n", 1)
    code = f"{head}\n{stubs}{rest}\nuint32_t check(void) {{\n{check}return wrong + first; }}\n"
    (tmp_path / "isr.c").write_text(code)
    subprocess.run(
        [
            "gcc",
            "-std=c99",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Wconversion",
            "-Werror",
            "-fsyntax-only",
            f"-I{exported.folder}",
            str(tmp_path / "isr.c"),
        ],
        check=True,
    )


def numbers(record: Array) -> list[float]:
    if record.dtype.names:
        return [x for name in record.dtype.names for x in numbers(record[name])]
    return [float(x) for x in np.atleast_1d(record)]


def test_params_are_the_design_to_the_bit(
    exported: Exported, motor: Motor, design: DriveDesign
) -> None:
    text = re.sub(r"/\*.*?\*/", "", (exported.folder / "params.c").read_text())
    body = text[text.index("drive_params = ") : text.index("schedule_params")]
    read = np.array(re.findall(r"(?<!\w)(-?\d[\d.e+-]*)f?[,\n]", body), dtype=np.float32)
    assert np.array_equal(read, np.array(numbers(control_record(motor, design)), dtype=np.float32))


def test_every_parameter_says_what_it_is(exported: Exported) -> None:
    text = (exported.folder / "params.c").read_text()
    body = text[text.index("drive_params = ") : text.index("schedule_params")]
    bare = [line for line in body.splitlines() if re.search(r"= -?\d", line) and "/*" not in line]
    assert not bare


@pytest.mark.parametrize(
    ("x", "literal"),
    [
        (0.0, "0.0f"),
        (1.0, "1.0f"),
        (-2.5, "-2.5f"),
        (1e20, "1.00000002e+20f"),
        (0.1, "0.100000001f"),
        (1e10, "1.0e+10f"),
        (1e-45, "1.40129846e-45f"),
    ],
)
def test_float_literals(x: float, literal: str) -> None:
    assert c_float(np.float32(x)) == literal


def test_float_literals_restore_every_bit() -> None:
    words: NDArray[np.uint32] = np.random.default_rng(7).integers(0, 2**32, 5000, dtype=np.uint32)
    x = words.view(np.float32)
    x = x[np.isfinite(x)]
    read = np.array([float(c_float(y)[:-1]) for y in x], dtype=np.float32)
    assert read.tobytes() == x.tobytes()
    with pytest.raises(UserError, match="k_p: inf; C code needs a finite number"):
        c_float(np.float32(np.inf), "k_p")

"""The headers of an export in every C and C++ that a project may be written in."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.export.export import Exported
from tests.helpers.objects import Failed, compiled, flags

WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
PROGRAM = """
int main() {
    drive_state_t drive;
    ks_schedule_state_t schedule;
    drive_init(&drive_params, &drive, 0.0f, 0.0f, 1.0f);
    return ks_schedule_init(&schedule_params, &schedule);
}
"""


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_headers_compile_without_a_warning(
    compiler: str, exported: Exported, tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler}: not found")
    headers = sorted(p.relative_to(exported.folder) for p in exported.folder.rglob("*.h"))
    assert {"params.h", "core/drive.h", "cmsis/ks_table_cmsis.h"} <= set(map(str, headers))
    for language, standards in (("c", ("c99", "c11", "c17")), ("c++", ("c++17", "c++20"))):
        source = tmp_path / ("all.c" if language == "c" else "all.cpp")
        source.write_text("".join(f'#include "{name}"\n' for name in headers))
        for standard in standards:
            flags = [f"-std={standard}", *WARNINGS, "-Wno-unused-const-variable"]
            words = [compiler, "-x", language, *flags, f"-I{exported.folder}"]
            done = subprocess.run(
                [*words, "-fsyntax-only", source], capture_output=True, text=True, check=False
            )
            assert done.returncode == 0 and not done.stderr, f"{standard}: {done.stderr}"


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_a_cpp_program_links_with_the_core(exported: Exported, tmp_path: Path) -> None:
    source = tmp_path / "main.cpp"
    source.write_text('#include "params.h"\n' + PROGRAM)
    made = list(exported.folder.glob("*.c"))
    objects = [str(tmp_path / f"{path.stem}.o") for path in made]
    how = ["gcc", *flags(exported.folder / "Makefile", "FLAGS"), "-O0"]
    subprocess.run([*how, "-c", *map(str, made)], cwd=tmp_path, check=True)
    core = compiled(exported.folder / "core", how)
    assert not isinstance(core, Failed), core.stderr
    objects += map(str, core)
    link = ["g++", "-std=c++20", f"-I{exported.folder}", str(source), *objects]
    subprocess.run([*link, "-o", str(tmp_path / "main")], check=True)
    subprocess.run([tmp_path / "main"], check=True)

"""libFuzzer with sanitizers over table check, schedule and control step, for a bounded time."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.export.export import export
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable

SECONDS = 10
FLAGS = (
    "-std=c99 -O1 -g -ffp-contract=off -fno-math-errno -fno-trapping-math "
    "-fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all"
).split()


def test_nothing_is_found(table: KsTable, motor: Motor, tmp_path: Path) -> None:
    folder = export(table, motor, DriveDesign(), tmp_path / "export").folder
    sources = [
        Path(__file__).with_name("fuzz.c"),
        *(folder / "core").glob("*.c"),
        *folder.glob("*.c"),
    ]
    program = tmp_path / "fuzz"
    command = ["clang", *FLAGS, f"-I{folder}", *map(str, sources), "-o", str(program)]
    built = (
        shutil.which("clang") is not None
        and not subprocess.run(command, capture_output=True, check=False).returncode
    )
    if not built and os.environ.get("CI") != "true":
        pytest.skip("needs the Debian packages clang, libclang-rt-dev")
    assert built
    (tmp_path / "corpus").mkdir()
    options = [f"-max_total_time={SECONDS}", "-max_len=600", "-seed=1", "-rss_limit_mb=1024"]
    done = subprocess.run(
        [str(program), *options, str(tmp_path / "corpus")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "Done" in done.stderr

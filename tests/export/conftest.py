"""What the tests of the export share."""

import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.export.export import Exported, export
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from tests.helpers.objects import Failed, compiled, flags, keep, place_of

SANITIZERS = ("-O1", "-fsanitize=fuzzer-no-link,address,undefined", "-fno-sanitize-recover=all")
"""Flags of what the self test and the fuzzer run, by clang."""


@pytest.fixture
def copied(exported: Exported, tmp_path: Path) -> Path:
    """Return a copy of the exported folder that a test may change."""
    return shutil.copytree(exported.folder, tmp_path / "copy")


def selftest(folder: Path, *settings: str) -> subprocess.CompletedProcess[str]:
    """``make selftest`` in a folder, and how it ended."""
    return subprocess.run(
        ["make", "selftest", *settings], cwd=folder, capture_output=True, text=True, check=False
    )


@dataclass(frozen=True)
class Made:
    """A copy of the exported folder after ``make selftest``, and how that ended."""

    folder: Path
    done: subprocess.CompletedProcess[str]


Make = Callable[[str, str], Made]


@pytest.fixture(scope="session")
def made(exported: Exported, tmp_path_factory: pytest.TempPathFactory) -> Make:
    """``make selftest`` of a compiler at a level, once; its objects are there for other tests."""

    @cache
    def make(compiler: str, level: str) -> Made:
        folder = shutil.copytree(exported.folder, tmp_path_factory.mktemp("made") / "folder")
        done = selftest(folder, f"CC={compiler}", f"CFLAGS={level}")
        if not done.returncode:
            command = [compiler, *flags(folder / "Makefile", "FLAGS"), level]
            keep(folder / "build" / "core", place_of(folder / "core", command))
        return Made(folder, done)

    return make


@pytest.fixture(scope="session")
def watched(exported: Exported) -> list[Path]:
    """Objects of the exported core with sanitizers; required where the environment says CI=true."""
    made: list[Path] | Failed[str] | None = None
    if shutil.which("clang"):
        how = ["clang", *flags(exported.folder / "Makefile", "FLAGS"), *SANITIZERS]
        made = compiled(exported.folder / "core", how)
    if isinstance(made, list):
        return made
    if os.environ.get("CI") == "true":
        pytest.fail("CI needs the Debian packages clang, libclang-rt-dev")
    pytest.skip("needs the Debian packages clang, libclang-rt-dev")


@pytest.fixture(scope="session")
def with_gains(motor: Motor, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Export that has passed its self test, where there is a compiler."""
    k_s = np.array([[1.0, 1.0], [0.6, 0.4], [0.0, 0.0]])
    grids = (
        GainGrid("observer", np.array([[0.0, 0.5], [1.0, -0.2], [0.3, 0.3]])),
        GainGrid("amplitude", np.array([[0.0, -0.5], [-1.0, -0.2], [0.0, 0.0]])),
    )
    axes = (Axis("speed", 0.1, 0.5, 3), Axis("disagreement", -1.0, 1.0, 2))
    table = KsTable(axes, k_s, gains=grids)
    folder = tmp_path_factory.mktemp("gains") / "export"
    return export(table, motor, DriveDesign(k_s_slew=table.slew_per_s), folder)

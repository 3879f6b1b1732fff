"""What the tests of the export share."""

import os
import shutil
from pathlib import Path

import pytest

from sensorless.export.export import Exported
from tests.helpers.objects import Failed, Objects, flags

SANITIZERS = ("-O1", "-fsanitize=fuzzer-no-link,address,undefined", "-fno-sanitize-recover=all")
"""Flags of what the self test and the fuzzer run, by clang."""


@pytest.fixture
def copied(exported: Exported, tmp_path: Path) -> Path:
    """Return a copy of the exported folder that a test may change."""
    return shutil.copytree(exported.folder, tmp_path / "copy")


@pytest.fixture(scope="session")
def watched(exported: Exported, core_objects: Objects) -> list[Path]:
    """Objects of the exported core with sanitizers; required where the environment says CI=true."""
    made: list[Path] | Failed[str] | None = None
    if shutil.which("clang"):
        how = ["clang", *flags(exported.folder / "Makefile", "FLAGS"), *SANITIZERS]
        made = core_objects.of(exported.folder / "core", how)
    if isinstance(made, list):
        return made
    if os.environ.get("CI") == "true":
        pytest.fail("CI needs the Debian packages clang, libclang-rt-dev")
    pytest.skip("needs the Debian packages clang, libclang-rt-dev")

"""The command line in this process: what a shell would see, without the start of a Python."""

import contextlib
import io
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from sensorless.cli.main import main


@dataclass(frozen=True)
class Done:
    """A command that has ended, with the names of ``subprocess.CompletedProcess``."""

    returncode: int
    stdout: str
    stderr: str


def run(*words: str, cwd: Path) -> Done:
    """``sensorless`` with these words in a folder, from its entry point to its exit status."""
    out, err = io.StringIO(), io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        patch.chdir(cwd)
        patch.setattr(sys, "argv", ["sensorless", *words])
        try:
            main()
            status = 0
        except SystemExit as stop:
            status = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    return Done(status, out.getvalue(), err.getvalue())


def process(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """``python -m sensorless`` with these words in a folder, in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "sensorless", *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )

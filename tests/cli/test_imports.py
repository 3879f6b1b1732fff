"""Quick commands do not load slow libraries, and a mistake ends with 2; a fresh process tells."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.command import run

STEPS = """
import os
import runpy
import sys

HEAVY = {"torch", "stable_baselines3", "matplotlib", "tensorboard", "ray", "cma", "jinja2"}


def run(*words, also=()):
    from typer.testing import CliRunner
    from sensorless.cli.app import app

    done = CliRunner().invoke(app, list(words), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    loaded = (HEAVY | set(also)) & set(sys.modules)
    assert not loaded, f"{words}: {sorted(loaded)}"


import sensorless

assert not (HEAVY | {"scipy", "filterpy"}) & set(sys.modules), "import sensorless"
science = ("scipy", "filterpy")
run("--help", also=science)
run("train", "--help", also=science)
run("evaluate", "--list", also=science)
run("simulate", "--duration", "0.02", "--log", "log.csv", also=science)

from sensorless.evaluation import compare
from sensorless.export import fit, judge

compare.SIZE = judge.SIZE = fit.SIZE = 8
os.environ["PATH"] = ""  # a self test of the export is C alone
run("export", "eq25", "--out", "exported")
run("replay", "log.csv")
print("done", flush=True)
sys.argv = ["sensorless", "evaluate", "--policy", "nobody"]
runpy.run_module("sensorless", run_name="__main__")
"""


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> subprocess.CompletedProcess[str]:
    """The process that took all steps, the last of which is a mistake."""
    folder = tmp_path_factory.mktemp("process")
    return subprocess.run(
        [sys.executable, "-c", STEPS], cwd=folder, capture_output=True, text=True, check=False
    )


def test_quick_commands_load_no_slow_library(done: subprocess.CompletedProcess[str]) -> None:
    assert done.stdout == "done\n", done.stderr


def test_a_mistake_ends_the_process_with_status_2(
    done: subprocess.CompletedProcess[str], tmp_path: Path
) -> None:
    assert done.returncode == 2
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1
    assert done.stderr == run("evaluate", "--policy", "nobody", cwd=tmp_path).stderr

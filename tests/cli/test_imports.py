"""Quick commands do not load slow libraries; a fresh process tells."""

import subprocess
import sys
from pathlib import Path

STEPS = """
import os
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
from sensorless.export import judge

compare.SIZE = judge.SIZE = 8
os.environ["PATH"] = ""  # a self test of the export is C alone
run("export", "eq25", "--out", "exported")
run("replay", "log.csv")
print("done")
"""


def test_quick_commands_load_no_slow_library(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", STEPS], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stdout == "done\n", done.stderr

"""A run ends with a sentence: better than its start or not, or that it never moved."""

import json
from pathlib import Path

import pytest

from sensorless.agents.loading import TABLE, VERDICT
from sensorless.agents.train.judge import judge
from sensorless.agents.train.run_folder import START
from sensorless.baselines.linear import linear_table
from sensorless.table.ks_table import KsTable
from tests.helpers.command import run

SMALL = "--n-envs 8 --n-epochs 1 --validate-size 16".split()
TINY = [*SMALL, *"--steps 64 --n-steps 8 --warm-up 9".split()]


@pytest.mark.usefixtures("brief")
def test_a_run_ends_with_its_verdict(tmp_path: Path) -> None:
    done = run("train", "--name", "still", *TINY, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder, last = tmp_path / "runs/still", done.stdout.splitlines()[-1]
    text = (
        "the same as its start, eq25: the run never moved: it had 64 decisions, and the table "
        "first moves after 640, with update 10 (--warm-up 9); go on with: sensorless train "
        "--resume runs/still"
    )
    assert last == f"verdict: {text}"
    assert json.loads((folder / VERDICT).read_text())["verdict"] == text

    known = KsTable.load(folder / TABLE).provenance
    linear_table(0.6, 0.9).save(folder / TABLE, known)
    sentence = judge(folder)
    assert "its start, eq25: objective" in sentence and "8 scenarios of stress-1" in sentence
    found = json.loads((folder / VERDICT).read_text())
    assert found["verdict"] == sentence and found["scenarios"] == 8


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--lr-nodes", "1e-6"], "the run never moved: in 1600 decisions no weight changed"),
        (["--lr-nodes", "1e-2"], "the run never moved k_s: its weights changed by up to"),
        (["--lr-nodes", "0.3", "--lr-end", "1", "--margin", "0"], "its start, eq25: "),
    ],
)
def test_whether_a_run_moved_is_told_by_its_weights(
    tmp_path: Path, given: list[str], said: str
) -> None:
    longer = ["--steps", "1600", "--n-steps", "100", "--warm-up", "0"]
    done = run("train", "--name", "slow", *SMALL, *longer, *given, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout.splitlines()[-1]
    folder = tmp_path / "runs/slow"
    if "never" not in said:
        start = KsTable.load(folder / START)
        start.save(folder / TABLE, KsTable.load(folder / TABLE).provenance)
        said = judge(folder)
        assert "the run's last weights move k_s by up to" in said and "none of 2 " in said

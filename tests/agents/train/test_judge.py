"""A run ends with a sentence: better than its start or not, or that it never moved."""

import json
from pathlib import Path

import pytest

from sensorless.agents.loading import TABLE, VERDICT
from sensorless.agents.train.judge import judge
from sensorless.agents.train.run_folder import PROGRESS
from sensorless.baselines.linear import linear_table
from sensorless.table.ks_table import KsTable
from tests.helpers.command import run

TINY = "--steps 64 --n-envs 8 --n-steps 8 --n-epochs 1 --validate-size 16 --warm-up 9".split()


@pytest.mark.usefixtures("brief")
def test_a_run_ends_with_its_verdict(tmp_path: Path) -> None:
    done = run("train", "--name", "still", *TINY, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder, last = tmp_path / "runs/still", done.stdout.splitlines()[-1]
    text = (
        "the same as its start, eq25: the run never moved: it had 64 decisions, and the table "
        "first moves after 640, with update 10 (warm_up = 9); go on with: sensorless train "
        "--resume runs/still"
    )
    assert last == f"verdict: {text}"
    assert json.loads((folder / VERDICT).read_text())["verdict"] == text

    rows = (folder / PROGRESS).read_text().splitlines()
    longer = ",".join(["641", *rows[-1].split(",")[1:]])
    (folder / PROGRESS).write_text("\n".join([*rows, longer]) + "\n")
    assert "all 3 validations are equal" in judge(folder) and "start a new run" in judge(folder)
    (folder / PROGRESS).write_text("\n".join([*rows, rows[-1].replace("0.", "1.")]) + "\n")
    assert "none of 3 validations was better" in judge(folder)

    known = KsTable.load(folder / TABLE).provenance
    linear_table(0.6, 0.9).save(folder / TABLE, known)
    sentence = judge(folder)
    assert "its start, eq25: objective" in sentence and "8 scenarios of stress-1" in sentence
    found = json.loads((folder / VERDICT).read_text())
    assert found["verdict"] == sentence and found["scenarios"] == 8

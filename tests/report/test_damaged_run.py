"""A run folder with a damaged file is refused before any work; a report that dies leaves none."""

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

pytest.importorskip("matplotlib")

from sensorless.agents.train.curve import COLUMNS
from sensorless.cli.app import app
from sensorless.errors import UserError

HEAD = ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("verdict.json", "[1", "verdict.json"),
        ("verdict.json", "{}", "verdict: None"),
        (
            "progress.csv",
            f"{HEAD}0,0,1,1,1,1,1\n1,1,1,1,1,nan,1\n",
            "objective: 'nan' is no finite",
        ),
        ("config.json", "[]", "config.json: [] has no fields"),
        ("config.json", "{}", "config.json: train: missing"),
    ],
)
def test_a_damaged_run_is_found_before_anything_is_judged(
    name: str, text: str, said: str, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def judge(*words: object) -> None:
        raise AssertionError("judged")

    monkeypatch.setattr("sensorless.report.report.judged", judge)
    damaged = shutil.copytree(run, tmp_path / "run")
    (damaged / name).write_text(text)
    done = CliRunner().invoke(app, ["report", str(damaged), "--out", str(tmp_path / "a" / "b")])
    assert isinstance(done.exception, UserError), done.exception
    assert said in str(done.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["run"], "no empty folder stays"


def test_there_is_no_folder_before_there_is_a_report(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So a process that is killed meanwhile cannot leave an empty one."""
    seen = []

    def judge(*words: object) -> None:
        seen.append(list(tmp_path.iterdir()))
        raise UserError("enough")

    monkeypatch.setattr("sensorless.report.report.judged", judge)
    CliRunner().invoke(app, ["report", str(run), "--out", str(tmp_path / "a" / "b")])
    assert seen == [[]]

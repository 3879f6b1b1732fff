"""``sensorless tune`` as a user meets it."""

import json
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.errors import UserError
from sensorless.tuning import rule_search
from sensorless.tuning.batch import costs
from tests.helpers.scenarios import lasting

RUN = CliRunner()


def test_a_result_is_a_policy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule_search, "suite", lasting(0.05))
    out = tmp_path / "mine.json"
    words = ["tune", "quadratic", "--budget", "20", "--seed", "2", "--out", str(out)]
    monkeypatch.setattr(sys, "argv", ["sensorless", *words])
    done = RUN.invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "quadratic:" in done.stdout and "lost" in done.stdout
    written = json.loads(out.read_text())
    last = done.stdout.splitlines()[-1]
    assert last == f"verdict: {written['provenance']['verdict']['verdict']}" and "its start" in last
    assert written["provenance"]["command"].startswith("sensorless tune quadratic --budget 20")
    results = tmp_path / "r.json"
    words = ["evaluate", "--policy", str(out), "--size", "2", "--out", str(results)]
    assert RUN.invoke(app, words).exit_code == 0
    assert list(json.loads(results.read_text())["policies"]) == ["mine"]


def test_ctrl_c_writes_the_best_and_tells_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rule_search, "suite", lasting(0.05))

    started = Mock(side_effect=[costs, KeyboardInterrupt])
    monkeypatch.setattr(rule_search, "costs", lambda *args: started()(*args))
    out = tmp_path / "mine.json"
    done = RUN.invoke(app, ["tune", "linear", "--budget", "20", "--out", str(out)])
    assert done.exit_code == 130
    assert json.loads(out.read_text())["provenance"]["interrupted"] is True


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["tune", "nobody"], "rule"),
        (["tune", "linear", "--budget", "1"], "budget"),
        (["tune", "hfi"], "no parameters"),
    ],
)
def test_a_mistake_is_found_before_the_work(words: list[str], said: str, tmp_path: Path) -> None:
    done = RUN.invoke(app, [*words, "--out", str(tmp_path / "a.json")])
    assert isinstance(done.exception, UserError)
    assert said in str(done.exception)
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_found_before_the_work(tmp_path: Path) -> None:
    done = RUN.invoke(app, ["tune", "linear", "--out", str(tmp_path / "no" / "a.json")])
    assert isinstance(done.exception, UserError)

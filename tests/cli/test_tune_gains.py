"""``sensorless tune gains`` as a user meets it."""

import json
from pathlib import Path
from unittest.mock import Mock

import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.design.words import design_from
from sensorless.errors import UserError
from sensorless.tuning.gains import search as searching
from sensorless.tuning.gains import verdict
from sensorless.tuning.gains.search import Search
from tests.helpers.scenarios import lasting

RUN = CliRunner()
WORDS = ["tune", "gains", "--evaluations", "11", "--size", "8"]


@pytest.fixture(autouse=True)
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (searching, verdict):
        monkeypatch.setattr(module, "suite", lasting(0.05))
    monkeypatch.setattr(searching, "JUDGED", 1)
    monkeypatch.setattr(verdict, "SIZE", 8)


def test_it_prints_the_words_and_the_verdict(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def judge(known: Search, values: dict[str, float], *_: object) -> None:
        known.best, known.best_value = values, 0.0

    monkeypatch.setattr(searching, "judge", judge)
    out = tmp_path / "gains.json"
    done = RUN.invoke(app, [*WORDS, "--set", "speed_hz=2", "--out", str(out)])
    assert done.exit_code == 0, done.output
    written = json.loads(out.read_text())
    assert done.stdout.splitlines()[-1] == f"verdict: {written['judged']['verdict']}"
    shown = next(line for line in done.stdout.splitlines() if line.startswith("settings: "))
    words = shown.removeprefix("settings: --set ").split(" --set ")
    design = design_from(words)
    assert design.speed_hz == 2.0 and "speed_hz" not in written["tuned"]
    assert all(getattr(design, name) == value for name, value in written["tuned"].items())
    assert "not held" in done.stdout and "dip" in done.stdout


def test_it_says_when_nothing_is_better(monkeypatch: pytest.MonkeyPatch) -> None:
    def costly(known: Search, values: dict[str, float], *_: object) -> None:
        known.centres.append(searching.Centre(0.0, 1.0, values))

    monkeypatch.setattr(searching, "judge", costly)
    done = RUN.invoke(app, [*WORDS, "--estimator", "smo"])
    assert done.exit_code == 0, done.output
    assert "smo_pll_hz" in done.stdout and "--set" not in done.stdout
    last = done.stdout.splitlines()[-1]
    assert "nothing better" in last and "without that, objective 0.000 instead of" in last


def test_ctrl_c_writes_the_best(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        searching, "cost", Mock(side_effect=[Mock(objective=1.0), KeyboardInterrupt])
    )
    out = tmp_path / "gains.json"
    done = RUN.invoke(app, [*WORDS, "--out", str(out)])
    assert done.exit_code == 130
    written = json.loads(out.read_text())
    assert written["interrupted"] is True
    assert design_from(written["words"]) == DriveDesign()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--estimator", "nobody"], "estimator"),
        (["--evaluations", "2"], "evaluations"),
        (["--policy", "flux_observer"], "brings a drive"),
        (["--set", "speed_hz=0"], "speed_hz"),
        (["--set", "estimator=smo", "--estimator", "flux"], "leave one out"),
        (["--seed", str(2**63)], "seed"),
        (["--out", "no/such/folder/a.json"], "no/such/folder"),
    ],
)
def test_a_mistake_ends_in_one_line(words: list[str], said: str) -> None:
    done = RUN.invoke(app, [*WORDS, *words])
    assert isinstance(done.exception, UserError)
    assert said in str(done.exception)


def test_rules_are_tuned_as_before() -> None:
    done = RUN.invoke(app, ["tune", "nobody", "--out", "a.json"])
    assert isinstance(done.exception, UserError) and "nobody" in str(done.exception)

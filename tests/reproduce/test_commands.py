"""``sensorless identify cross-coupling`` and ``reproduce`` on the command line."""

import json
from pathlib import Path

import pytest

from sensorless.machine.motor import Motor
from sensorless.reproduce import reproduce
from sensorless.reproduce.case import Case
from sensorless.reproduce.printed import timing
from tests.helpers.command import run


def test_identify_writes_data_and_picture(tmp_path: Path) -> None:
    words = "identify cross-coupling --set mtpa=false --out cc.json --plot cc.png".split()
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads((tmp_path / "cc.json").read_text(encoding="utf-8"))
    assert data["line"]["slope_deg_per_A"] == pytest.approx(-3.96, abs=0.15)
    assert f"{data['line']['slope_deg_per_A']:.3f}" in done.stdout
    assert (tmp_path / "cc.png").read_bytes().startswith(b"\x89PNG")


def test_reproduce_prints_its_numbers_for_programs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the shortest of its cases alone; the output is the file that it writes, and no more."""

    def cases(motor: Motor, progress: object) -> list[Case]:
        assert not list(tmp_path.iterdir()), "a process that is killed leaves no empty folder"
        return [timing(motor)]

    monkeypatch.setattr(reproduce, "cases", cases)
    done = run("reproduce", "--json", "--out", "paper", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout == (tmp_path / "paper" / "paper.json").read_text(encoding="utf-8")
    assert list(json.loads(done.stdout)["cases"]) == ["timing"]
    assert "paper.md" in done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["identify", "cross-coupling", "--motor", "nomotor"], "paper"),
        (["identify", "cross-coupling", "--out", "no/such/file.json"], "out"),
        (["identify", "cross-coupling", "--set", "mtpa=maybe"], "mtpa"),
        (["reproduce", "--out", "/proc/none"], "/proc/none"),
    ],
)
def test_mistakes_are_one_line(words: list[str], said: str, tmp_path: Path) -> None:
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1

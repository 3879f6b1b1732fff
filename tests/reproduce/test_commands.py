"""``sensorless identify cross-coupling`` and ``reproduce`` on the command line."""

import json
from pathlib import Path

import pytest

from tests.helpers.command import run


def test_identify_writes_data_and_picture(tmp_path: Path) -> None:
    words = "identify cross-coupling --set mtpa=false --out cc.json --plot cc.png".split()
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads((tmp_path / "cc.json").read_text(encoding="utf-8"))
    assert data["line"]["slope_deg_per_A"] == pytest.approx(-3.96, abs=0.15)
    assert f"{data['line']['slope_deg_per_A']:.3f}" in done.stdout
    assert (tmp_path / "cc.png").read_bytes().startswith(b"\x89PNG")


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

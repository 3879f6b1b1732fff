"""Policies are set beside each other on one control: what tells those that bring another."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("matplotlib")

from sensorless.baselines.linear import eq25_band, linear_table
from sensorless.design.carried import record
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.policies.bench import bench
from sensorless.report.control import other_control
from sensorless.report.report import Report

pytestmark = pytest.mark.usefixtures("short_suites")

PAPER, BOTH = Motor.load("paper"), ("stress-1", "machines")


def made_on(folder: Path, **settings: Any) -> str:
    """File of Eq. 25 as a table that was made on these settings."""
    path = folder / "own.json"
    linear_table(*eq25_band(PAPER)).save(path, record(DriveDesign(**settings), PAPER))
    return str(path)


def apart(words: list[str], asked: list[str] | None = None) -> dict[str, str]:
    made = bench(words, None, asked, override=True)
    return other_control(made, BOTH, 7, 32, words)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"speed_hz": 1.0}, "--set speed_hz=1"),
        ({"current_hz": 80.0, "estimator": "flux"}, "--set current_hz=80"),
        ({"dead_time_share": 0.5, "mtpa": False}, "--set dead_time_share=0.5 --set mtpa=false"),
        ({"speed_hz": 1.0, "i_q_slew": 30.0}, "--set speed_hz=1 --set i_q_slew=30"),
        ({"estimator": "smo", "smo_pll_hz": 30.0, "k_s_slew": 7.0}, None),
        ({"speed_hz": asdict(derive(PAPER, DriveDesign()))["speed_hz"]}, None),
    ],
)
def test_what_moves_the_twin_is_another_control(
    settings: dict[str, Any], said: str | None, tmp_path: Path
) -> None:
    """And what moves the estimated angle alone is not; with the options both have one control."""
    words = [made_on(tmp_path, **settings), "eq25", "sliding_mode", "linear-coupled-tuned"]
    others = dict.fromkeys(words[1:], f"{said} --override")
    found = other_control(bench(words), ("stress-1",), 7, 32, words)
    assert found == (others if said else {})
    if said is not None:
        assert not apart(words, [x for x in said.split() if x != "--set"])
        assert list(apart(["eq25", words[0]])) == ["own"]


def test_shipped_policies_have_one_control() -> None:
    words = ["reference-flux", "eq25", "reference", "sliding_mode", "linear-tuned", "ppo-smo-gains"]
    assert not apart(words)


def test_beside_another_control_nothing_is_better(tmp_path: Path) -> None:
    """A softer speed loop deviates less from its own twin, whatever the weight does."""
    words = [made_on(tmp_path, speed_hz=1.0), "eq25", "linear-coupled-tuned"]
    report = Report(words[0], bench(words), others=words[1:])
    page, said = report.write(tmp_path / "page", ["stress-1"], 7, 24, 2, "sensorless report")
    assert said.word == "no" and said.head == "Nothing to judge by."
    assert "add --set speed_hz=1 --override." in said.because
    text = page.read_text(encoding="utf-8")
    assert "nothing here is better or worse" in text
    assert not [word for word in ("better", "worse", "same") if f'class="{word}"' in text]
    assert "linear-coupled-tuned on" not in text, "nor is it the best rule to stand beside"

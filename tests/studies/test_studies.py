"""The recorded studies: they write what they found and go on where they stopped."""

import json
import math
import re
import runpy
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

from sensorless.agents.train.config import TrainConfig
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from tests.helpers.script import script

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Small(TrainConfig):
    """Fewer drives than anybody would train with."""

    n_envs: int = 16
    validate_size: int = 16


def study(name: str) -> ModuleType:
    module = script(f"studies/{name}.py")
    vars(module)["TrainConfig"] = Small
    return module


def run(module: ModuleType, monkeypatch: pytest.MonkeyPatch, *words: str) -> None:
    monkeypatch.setattr(sys, "argv", [module.__name__, *words])
    module.main()


@pytest.mark.usefixtures("brief")
def test_axes_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module, out = study("axes_study"), tmp_path / "axes.json"
    words = ("--steps", "512", "--size", "8", "--out", str(out), "--sets", "speed", "--seeds")
    run(module, monkeypatch, *words, "1")
    first = json.loads(out.read_text())["runs"]
    monkeypatch.setattr(module, "train", lambda *_: pytest.fail("it was trained already"))
    run(module, monkeypatch, *words, "1")
    assert json.loads(out.read_text())["runs"] == first
    assert [(r["set"], r["seed"], r["steps"]) for r in first] == [("speed", 1, 512)]
    assert 0.0 < first[0]["torque_dev_rms"] < 1.0 and first[0]["survived_both"] <= 8
    for other in (("1", "2"), ("1", "--motor", "ipmsm_2200w")):
        with pytest.raises(pytest.fail.Exception):
            run(module, monkeypatch, *words, *other)


def test_every_set_of_axes_can_be_trained() -> None:
    for axes in study("axes_study").SETS.values():
        table = TrainConfig(axes=axes).start_table(
            table_named("eq25", Motor.load("paper")), Motor.load("paper"), 50.0
        )
        assert len(table.axes) == len(axes.split(","))


@pytest.mark.usefixtures("brief")
def test_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("optuna")
    module, out = study("ppo_search"), tmp_path / "ppo.json"
    words = ("--steps", "512", "--size", "8", "--seeds", "1", "--out", str(out), "--trials")
    run(module, monkeypatch, *words, "1")
    run(module, monkeypatch, *words, "2")
    trials = json.loads(out.read_text())["trials"]
    assert sorted(t["number"] for t in trials) == [0, 1]
    assert trials[0]["objective"] <= trials[1]["objective"]
    chosen = next(t for t in trials if t["number"] == 0)["settings"]
    assert {k: chosen[k] for k in module.SEARCHED} == {
        k: getattr(module.TrainConfig(), k) for k in module.SEARCHED
    }
    monkeypatch.setattr(module, "train", lambda *_: pytest.fail("there are enough trials"))
    run(module, monkeypatch, *words, "2")


@pytest.mark.parametrize("words", [("lock_study", "--motor"), ("leaderboard", "--policy")])
def test_a_mistake_is_told_in_one_line(
    words: tuple[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    name, option = words
    monkeypatch.setattr(sys, "argv", [f"{name}.py", option, "nope"])
    with pytest.raises(SystemExit, match=r"^error: (motor|policy).*'nope'"):
        runpy.run_path(str(ROOT / "studies" / f"{name}.py"), run_name="__main__")


OUT = ["any_machine", "axes_study", "best_schedules", "bring_up_study", "carrier_study",
       "damage_campaign", "datasheet_study", "fault_campaign", "handover_study", "hard_suite",
       "identify_study", "lock_study", "motors_study", "one_schedule", "ppo_search", "q15_study",
       "return_study", "standstill_study", "zero_shot"]  # fmt: skip


@pytest.mark.parametrize("name", OUT)
def test_a_record_that_cannot_be_written_is_told_first(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [f"{name}.py", "--out", "/proc/nope/x.json"])
    with pytest.raises(SystemExit, match=r"^error: out.*/proc/nope"):
        runpy.run_path(str(ROOT / "studies" / f"{name}.py"), run_name="__main__")


def test_the_scenarios_of_the_lock_study_fit_every_suite() -> None:
    """The suite envelope is a grid."""
    text = (ROOT / "studies" / "lock_study.py").read_text(encoding="utf-8")
    size = re.search(r'"--size",\s*type=a_count,\s*default=(\d+)', text)
    assert size and math.isqrt(int(size[1])) ** 2 == int(size[1])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("bring_up_study", "--seed", "-1"), "--seed: seed: -1; give 0 to 2^63 - 1"),
        (("fault_campaign", "--seeds", "0"), "--seeds: 0; give 1 or more"),
        (("clairvoyant", "--generations", "few"), "--generations: 'few'; give a whole number"),
    ],
)
def test_a_wrong_number_is_told(
    words: tuple[str, ...],
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    name, *rest = words
    with pytest.raises(SystemExit):
        run(study(name), monkeypatch, *rest)
    assert said in capsys.readouterr().err

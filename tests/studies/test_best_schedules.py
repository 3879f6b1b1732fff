"""The study behind ``sensorless motors``: the best of a few, and Eq. 25 where none is better."""

import json
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from sensorless.evaluation.compare import Comparison
from sensorless.evaluation.objective import Cost
from sensorless.export.judge import Judged
from sensorless.machine.motor import Motor
from sensorless.policies.best import best
from sensorless.policies.tuned import Tuned
from sensorless.policy import Policy
from tests.helpers.script import script

COST = Cost(0.0, 0.03, 0.01)
LEVEL = Comparison("Eq. 25", 400, 400, COST, COST, 0.0, (-1e-3, 1e-3), False)
BETTER = replace(LEVEL, change=-0.1, interval=(-0.2, -0.05))


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The study with made-up tuning: the logistic rule is always the better one."""

    def tune(name: str, *_: object) -> Tuned:
        spec = "linear:100,300" if name == "linear" else "logistic"
        known = {"policy": spec, "best": {"objective": len(name) / -100.0}}
        return Tuned(name, {}, known)

    made = script("studies/best_schedules.py")
    monkeypatch.setattr(made, "tune", tune)
    return made


@pytest.mark.parametrize(
    ("found", "policy"),
    [(BETTER, "logistic"), (LEVEL, "eq25"), (replace(BETTER, hops=0.17), "eq25")],
)
def test_the_best_is_recorded_once(
    found: Comparison,
    policy: str,
    module: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judged: list[str] = []

    def judge(rule: Policy, *_: object) -> Judged:
        judged.append(rule.name)
        return Judged(0, 200, 200, found)

    monkeypatch.setattr(module, "judge_export", judge)
    out = tmp_path / "schedules.json"
    monkeypatch.setattr(sys, "argv", ["study", "--motor", "paper", "--out", str(out)])
    module.main()
    entry = best(Motor.load("paper"), out)
    assert entry is not None and entry.fresh and entry.policy == policy
    assert ("no tuned rule is better" in entry.verdict) == (policy == "eq25")
    assert judged[0] == "logistic", "the least objective of the two"
    text, count = out.read_text(), len(judged)
    module.main()
    assert out.read_text() == text and len(judged) == count, "and not tuned again"
    assert json.loads(text)["rules"] == ["linear", "logistic"]

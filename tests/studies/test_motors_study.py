"""The study over the shipped machines: its verdict, its record, and going on with it."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from sensorless.evaluation.evaluate import Scores
from tests.helpers.script import script

N = 400


@pytest.fixture(scope="module")
def module() -> ModuleType:
    return script("studies/motors_study.py")


def scores(module: ModuleType, lost: int, deviation: float) -> Scores:
    """The first ``lost`` scenarios lost; deviations spread around a mean."""
    spread = np.random.default_rng(1).uniform(0.9, 1.1, N)
    bits = np.where(np.arange(N) < lost, 1, 0).astype(np.int32)
    metrics = {name: deviation * spread for name in module.METRICS}
    return Scores(bits, np.ones(N), metrics, {}, {})


@pytest.mark.parametrize(
    ("lost", "deviation", "good"),
    [(10, 0.05, True), (10, 0.0505, True), (10, 0.052, False), (60, 0.04, False), (0, 0.04, True)],
)
def test_verdict(module: ModuleType, lost: int, deviation: float, good: bool) -> None:
    """Against 10 of 400 lost, 5 % deviation, and with 2 % of it as margin."""
    found = module.compared(scores(module, lost, deviation), scores(module, 10, 0.05), 3)
    assert found["no_worse"] is good
    assert found["relative"]["torque_dev_rms"]["mean"] == pytest.approx(deviation / 0.05 - 1.0)
    assert found["survived_both"] == N - max(lost, 10)


def test_it_goes_on_where_it_stopped(
    module: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "motors.json"
    words = [
        "motors_study", "--policy", "hfi", "--against", "eq25", "--size", "4", "--out", str(out)
    ]  # fmt: skip
    monkeypatch.setattr(sys, "argv", [*words, "--motor", "paper"])
    module.main()
    first = json.loads(out.read_text())
    assert set(first["machines"]) == {"paper"}
    assert set(first["machines"]["paper"]["policies"]) == {"eq25", "hfi"}
    asked: list[str] = []

    def counted(name: str, *_: object) -> object:
        asked.append(name)
        return first["machines"]["paper"]

    monkeypatch.setattr(module, "study", counted)
    monkeypatch.setattr(sys, "argv", words)
    module.main()
    assert asked == ["ipmsm_2200w", "pmsyrm_5600w"]
    assert json.loads(out.read_text())["machines"]["paper"] == first["machines"]["paper"]
    monkeypatch.setattr(sys, "argv", [*words, "--motor", "paper", "--seed", "12"])
    module.main()
    assert asked[2:] == ["paper"], "another seed is another record"

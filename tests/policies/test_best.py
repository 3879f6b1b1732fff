"""The schedules that ``sensorless motors`` shows are of its machines, and say when they are old."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.best import best, identity
from sensorless.policies.registry import make_policy
from tests.helpers.command import run

PAPER = Motor.load("paper")


@pytest.fixture
def record(tmp_path: Path) -> Path:
    path = tmp_path / "schedules.json"
    entry = {
        "on": identity(PAPER),
        "policy": "linear:100,300",
        "verdict": "better than Eq. 25",
        "judged": {"objection": ""},
    }
    path.write_text(json.dumps({"machines": {"paper": entry}}))
    return path


def test_an_entry_is_fresh_until_machine_or_drive_change(
    record: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = best(PAPER, record)
    assert found is not None and found.fresh and found.policy == "linear:100,300"
    other = best(replace(PAPER, J=0.03), record)
    assert other is not None and not other.fresh
    monkeypatch.setattr("sensorless.policies.best.fingerprint", lambda *_: {"observer": "other"})
    changed = best(PAPER, record)
    assert changed is not None and not changed.fresh
    assert best(replace(PAPER, name="unheard of"), record) is None
    assert best(PAPER, record.with_name("none.json")) is None


def test_every_shipped_machine_has_one_that_runs(tmp_path: Path) -> None:
    said = run("motors", cwd=tmp_path).stdout
    for path in MOTORS.glob("*.toml"):
        motor = Motor.load(path)
        found = best(motor)
        assert found is not None, f"run studies/best_schedules.py --motor {motor.name}"
        assert make_policy(found.policy, motor).name == found.policy
        assert f"{motor.name}: --policy {found.policy}\n  {found.verdict}" in said
        assert not found.objection or f"unfit for export: {found.objection}" in said

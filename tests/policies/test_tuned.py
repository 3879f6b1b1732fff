"""Files of tuned rules: written whole, read with care."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, make_policy
from sensorless.policies.tuned import FORMAT, Tuned
from sensorless.policy import TablePolicy

PAPER = Motor.load("paper")
GOOD: dict[str, Any] = {
    "format": FORMAT,
    "rule": "linear",
    "parameters": {"lo": 0.1, "hi": 0.5},
    "provenance": {},
}


def test_a_file_is_a_policy_of_its_name(tmp_path: Path) -> None:
    path = tmp_path / "linear-tuned.json"
    Tuned("linear", {"lo": 0.1, "hi": 0.5}, {"seed": 1}).save(path)
    for spec in (str(path), f"tuned:{path}"):
        policy = make_policy(spec, PAPER)
        assert isinstance(policy, TablePolicy)
        assert policy.name == "linear-tuned"
        axis = policy.table.axes[0]
        assert (axis.lo, axis.hi) == pytest.approx((0.1, 0.5))
    assert Tuned.load(path) == Tuned("linear", {"lo": 0.1, "hi": 0.5}, {"seed": 1})
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("rule", ["linear", "hysteresis", "gated", "logistic"])
def test_it_runs_on_the_estimator_it_was_tuned_on(rule: str, tmp_path: Path) -> None:
    """With or without a table; a file that does not tell is from before there was a choice."""
    path = tmp_path / "a.json"
    for origin, estimator in (({"design": {"estimator": "flux"}}, "flux"), ({}, "smo")):
        Tuned(rule, RULES[rule].defaults(), origin).save(path)
        assert make_policy(str(path), PAPER).settings["estimator"] == estimator


def test_its_speeds_are_shares_of_rated_speed_on_any_machine(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(GOOD))
    fast = make_policy(str(path), replace(PAPER, n_rated_rpm=3000.0))
    assert isinstance(fast, TablePolicy)
    assert fast.table.axes[0].hi == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "x"}, "format"),
        ({"rule": "nobody"}, "rule"),
        ({"rule": 3}, "rule"),
        ({"parameters": {"lo": 0.1}}, "parameters"),
        ({"parameters": {"lo": 0.5, "hi": 0.1}}, "parameters"),
        ({"parameters": {"lo": 0.1, "hi": 0.5, "x": 1}}, "parameters"),
        ({"parameters": {"lo": "0.1", "hi": 0.5}}, "parameters"),
        ({"parameters": {"lo": 0.1, "hi": float("nan")}}, "parameters"),
        ({"parameters": {"lo": True, "hi": 2}}, "parameters"),
        ({"parameters": [1]}, "parameters"),
        ({"provenance": 1}, "provenance"),
        ({"rule": 10**4000}, "rule: 10+ ..."),
    ],
)
def test_a_file_that_was_changed_is_refused(
    change: dict[str, Any], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({**GOOD, **change}))
    with pytest.raises(UserError, match=said) as caught:
        make_policy(f"tuned:{path}", PAPER)
    said = str(caught.value)
    assert str(path) in said and "\n" not in said and len(said) < 500


@pytest.mark.parametrize("text", [None, "", "[]", "{", "\udcff"])
def test_a_file_that_is_none_is_refused(text: str | None, tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    if text is not None:
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(UserError, match=r"a\.json"):
        make_policy(str(path), PAPER)

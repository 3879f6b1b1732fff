"""The fuzzy table is its rule base, as the library evaluates it."""

import sys
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.fuzzy import LEVELS, RULES, TERMS, FuzzySystem, fuzzy_table, peak_values
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Signals, TablePolicy

pytest.importorskip("simpful")


def test_the_table_is_the_system_everywhere(signals: Callable[..., Signals]) -> None:
    table = fuzzy_table(0.1, 0.4, 3.0, 0.8)
    points = np.random.default_rng(3).uniform(0.0, 1.0, (300, 3))
    obs = signals(
        speed=0.1 + 0.3 * points[:, 0],
        acceleration=3.0 * (2.0 * points[:, 1] - 1.0),
        disagreement=0.8 * (2.0 * points[:, 2] - 1.0),
    )
    system = FuzzySystem()
    wanted = [system(*map(float, point)) for point in points]
    assert np.abs(table.evaluate(obs) - wanted).max() < 1e-6


def test_the_rules_name_only_known_terms_and_cover_all_speeds() -> None:
    text = " ".join(RULES)
    for name, terms in TERMS.items():
        for term in terms:
            if name != "disagreement" or term == "small":
                assert f"({name} IS {term})" in text
    assert all(f"(k_s IS {level})" in text for level in LEVELS)


def test_the_reasoning_holds() -> None:
    k_s = peak_values()
    assert (np.diff(k_s, axis=0) <= 0).all(), "less injection at more speed"
    assert (np.diff(k_s, axis=1) <= 0).all(), "hand over early when speeding up"
    assert (k_s == k_s[:, :, ::-1]).all(), "both signs of disagreement count alike"
    assert (k_s[:, :, 0] >= k_s[:, :, 1]).all(), "and keep the injection"
    assert (k_s[0] == 1.0).all() and (k_s[-1] == 0.0).all()


def test_the_command_line_has_r_min_and_degrees() -> None:
    """The signal of the disagreement is 1 at 30 degrees, that of the speed at rated speed."""
    policy = make_policy("fuzzy:150,600,4,15", Motor.load("paper"))
    assert isinstance(policy, TablePolicy)
    ends = {axis.signal: (axis.lo, axis.hi) for axis in policy.table.axes}
    assert ends["speed"] == pytest.approx((0.1, 0.4))
    assert ends["acceleration"] == pytest.approx((-4.0, 4.0))
    assert ends["disagreement"] == pytest.approx((-0.5, 0.5))


def test_says_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    FuzzySystem()(0.2, 0.3, 0.4)
    assert capsys.readouterr().out == ""


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    peak_values.cache_clear()
    monkeypatch.setitem(sys.modules, "simpful", None)
    with pytest.raises(UserError, match=r"sensorless\[fuzzy\]"):
        make_policy("fuzzy", Motor.load("paper"))

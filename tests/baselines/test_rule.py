"""What is taken from the command line, and what is refused."""

import pytest

from sensorless.baselines.rule import SPEED_UNIT, Rule
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES

PAPER = Motor.load("paper")
GATED = RULES["gated"]


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.name)
def test_defaults_lie_in_the_range_that_tuning_searches(rule: Rule) -> None:
    assert rule.allows(rule.defaults())
    for p in rule.parameters:
        assert p.least <= p.low <= p.default <= p.high <= p.most, p.name
        assert p.low < p.high
        assert p.doc and p.unit in (SPEED_UNIT, "1", "deg", "ms", "%", "1/s")


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.name)
def test_the_word_of_some_values_gives_them_back(rule: Rule) -> None:
    word = rule.spec(rule.defaults(), PAPER)
    name, colon, text = word.partition(":")
    values = rule.parse(word, text if colon else None, PAPER)
    assert name == rule.name
    assert values == pytest.approx(rule.defaults(), rel=1e-5)


def test_numbers_by_name_leave_the_others_alone() -> None:
    values = GATED.parse("gated", "release=40,LO=150", PAPER)
    assert values == {**GATED.defaults(), "release": 40.0, "lo": 0.1}


@pytest.mark.parametrize(
    "text",
    [
        "150",
        "release=nan",
        "release=inf",
        "release=-1",
        "release",
        "release=20,release=30",
        "nothing=1",
        "release=20,30",
        "lo=500",
        "",
        "=",
    ],
)
def test_what_cannot_be_meant_is_refused(text: str) -> None:
    with pytest.raises(UserError, match="LO < HI") as caught:
        GATED.parse(f"gated:{text}", text, PAPER)
    assert "\n" not in str(caught.value)
    assert "RELEASE from 0 or more deg" in str(caught.value)


def test_a_long_list_of_parameters_is_cut_short() -> None:
    assert RULES["grid"].usage == "grid[:K_0_0_0,K_0_0_1,...,K_5_2_2]"
    with pytest.raises(UserError) as caught:
        RULES["grid"].parse("grid:1", "1", PAPER)
    assert len(str(caught.value)) < 400

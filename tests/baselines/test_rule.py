"""What is taken from the command line, and what is refused."""

import pytest

from sensorless.baselines.rule import Rule
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES

PAPER = Motor.load("paper")
GATED = RULES["gated"]


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.name)
def test_defaults_lie_in_the_range_that_tuning_searches(rule: Rule) -> None:
    assert rule.allows(rule.defaults())
    for p in rule.parameters:
        low, high = p.search
        assert p.low <= low <= p.default <= high <= p.high, p.name
        assert low < high
        assert p.meaning and p.unit in ("r/min", "1", "deg", "ms", "%", "1/s")


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


COUNT = "give all 7 numbers in order, or some as NAME=VALUE: gated[:LO,HI,FORCE,"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("150", COUNT),
        ("release=nan", "release: nan: must be a finite number at least 0 deg"),
        ("release=inf", "release: inf: must be a finite number at least 0 deg"),
        ("release=-1", "release: -1.0: must be at least 0 deg (disagreement that ends a way up)"),
        ("release=x", "release: 'x': must be a number at least 0 deg"),
        ("force=16000", "force: 16000.0: must be between 0 and 15000 r/min"),
        ("release", COUNT),
        ("release=20,release=30", COUNT),
        ("nothing=1", COUNT),
        ("release=20,30", COUNT),
        ("lo=500", "LO must be below HI"),
        ("", COUNT),
        ("=", COUNT),
    ],
)
def test_what_cannot_be_meant_is_refused(text: str, said: str) -> None:
    """In the units of the command line."""
    with pytest.raises(UserError) as caught:
        GATED.parse(f"gated:{text}", text, PAPER)
    assert str(caught.value).startswith(f"policy 'gated:{text}': {said}")
    assert "\n" not in str(caught.value)


def test_a_long_list_of_parameters_is_cut_short() -> None:
    assert RULES["grid"].usage == "grid[:K_0_0_0,K_0_0_1,...,K_5_2_2]"
    with pytest.raises(UserError) as caught:
        RULES["grid"].parse("grid:1", "1", PAPER)
    assert len(str(caught.value)) < 400

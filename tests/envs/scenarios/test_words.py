"""A scenario by its word: the suite's own row, and what no suite has."""

import dataclasses

import numpy as np
import pytest

from sensorless.envs.scenarios.suites import suite
from sensorless.envs.scenarios.words import plan_from, scenario_from
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

PAPER = Motor.load("paper")


@pytest.mark.parametrize(("name", "size"), [("stress", 8), ("motors", 8), ("envelope", 16)])
def test_a_word_names_a_row_of_its_suite(name: str, size: int) -> None:
    one, row = scenario_from(f"{name}:3:7:{size}", PAPER), suite(name, PAPER, 3, size)[7:8]
    for field in dataclasses.fields(row):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(row, field.name))


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("stress:3", "write SUITE:SEED:INDEX"),
        ("envelope:3:7", "append :SIZE"),
        ("envelope:3:16:16", "give an INDEX below SIZE"),
        ("stress:3:10000000", "give an INDEX below 10000000"),
        ("stress:3:5:90000000", "size: 90000000; give 1 to 10000000"),
    ],
)
def test_other_words_are_refused(word: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        scenario_from(word, PAPER)


def test_the_rotor_is_turned_and_not_the_drive() -> None:
    """So that a start seeks another rotor, and not the same one from another guess."""
    for start in (False, True):
        case = plan_from("0:0", "0:0", None, 1.0, PAPER, 0, start=start, theta_err=100.0)
        assert np.rad2deg(case.theta_0) == pytest.approx(100.0)
        assert np.rad2deg(case.theta_err_0) == pytest.approx(100.0)

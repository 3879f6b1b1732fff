"""Scenarios of a user: mistakes are named, and what the suites draw passes as it is."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.checked import checked_scenarios
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import SUITES, suite
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
DRAWN = stress_1_scenarios(MOTOR, np.arange(6, dtype=np.uint64))
BACK = np.array([[0.0, 0.5, 0.4, *[np.inf] * (DRAWN.t.shape[1] - 3)]])


@pytest.mark.parametrize("name", sorted(SUITES))
def test_what_a_suite_draws_passes_unchanged(name: str) -> None:
    size = 49 if name == "envelope" else 48
    drawn = suite(name, MOTOR, 3, size)
    found = checked_scenarios(drawn, len(drawn), "x")
    for f in fields(Scenarios):
        before, after = getattr(drawn, f.name), getattr(found, f.name)
        assert before.dtype == after.dtype and np.array_equal(before, after)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"J": [-1.0]}, "J: -1.0 in row 0; give finite numbers above 0"),
        ({"J": [0.0]}, "J: 0.0 in row 0; give finite numbers above 0"),
        ({"J": [1.0, 1.0]}, "J: shape (2,); give (1,)"),
        ({"J": ["big"]}, "J: ['big']; give numbers"),
        ({"noise": [np.nan]}, "noise: nan in row 0; give finite numbers, none below 0"),
        ({"R_s": [np.nan]}, "R_s: nan in row 0"),
        ({"duration": [np.nan]}, "duration: nan in row 0"),
        ({"theta_0": [np.inf]}, "theta_0: inf in row 0; give finite numbers"),
        ({"tau": [0.0]}, "tau: shape (1,); give (1, "),
        ({"omega": [[1.0, 2.0], [3.0]]}, "omega: [[1.0, 2.0], [3.0]]; give numbers"),
        ({"seek": [1.0]}, "seek: [1.0]; give True or False"),
        ({"seed": 7}, "seed: shape (); give (1,)"),
        ({"t": BACK}, "in row 0; begin at 0 and go up"),
    ],
)
def test_a_wrong_number_is_named(parts: dict[str, Any], said: str) -> None:
    one = replace(DRAWN[3:4], **parts)
    with pytest.raises(UserError) as caught:
        BlendEnv().reset(options={"scenario": one})
    assert str(caught.value).startswith("options['scenario']: ") and said in str(caught.value)

    def draw(motor: Motor, seeds: Seeds) -> Scenarios:
        return one

    with pytest.raises(UserError, match=r"^scenarios: "):
        BlendEnv(scenarios=draw).reset(seed=1)


def test_one_row_by_its_number() -> None:
    env = BlendEnv()
    by_slice, by_number = (env.reset(options={"scenario": s})[0] for s in (DRAWN[2:3], DRAWN[2]))
    np.testing.assert_array_equal(by_slice, by_number)
    assert len(DRAWN[-1]) == 1 and DRAWN[-1].seed == DRAWN.seed[-1]

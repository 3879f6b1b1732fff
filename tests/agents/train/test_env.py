"""How many scenarios of a training run come from which suite."""

from dataclasses import fields

import numpy as np
import pytest

from sensorless.agents.train import env
from sensorless.agents.train.env import training_scenarios, with_others
from sensorless.envs.blend_settings import Sampler
from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

LONG = {"unload": 100.0, "hold": 200.0, "stop": 300.0}


def marked(name: str) -> Sampler:
    """In place of the sampler of a suite: scenarios whose duration tells it."""

    def draw(motor: Motor, seeds: Seeds) -> Scenarios:
        usual = training_scenarios(motor, seeds)
        out = {f.name: getattr(usual, f.name).copy() for f in fields(usual)}
        out["duration"][:] = LONG[name]
        return Scenarios(**out)

    return draw


def test_every_other_suite_has_its_share(motor: Motor, monkeypatch: pytest.MonkeyPatch) -> None:
    """A share of 4000 misses by 2.3 % in one of a thousand trials at most."""
    monkeypatch.setattr(env, "sampler", marked)
    shares = {"unload": 0.3, "hold": 0.1, "stop": 0.2}
    drawn = with_others(shares)(motor, np.arange(4000, dtype=np.uint64)).duration
    for name, share in shares.items():
        assert np.mean(drawn == LONG[name]) == pytest.approx(share, abs=0.023)
    assert np.mean(drawn < 100.0) == pytest.approx(0.4, abs=0.023)

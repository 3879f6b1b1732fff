"""Numbers that are chosen instead of drawn."""

import dataclasses

import numpy as np

from sensorless.envs.counter_random import Chosen, Draws, combine
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.machine.motor import Motor

SEEDS = np.arange(5, dtype=np.uint64)


def test_chosen_numbers_are_used_and_others_drawn() -> None:
    source = Chosen(SEEDS, {(0, 2): np.full(5, 0.25)})
    chosen, drawn = Draws(source), Draws(SEEDS)
    assert np.array_equal(chosen.uniform(), drawn.uniform())
    assert np.array_equal(chosen.uniform(2.0, 4.0), np.full(5, 2.5))
    assert set(source.units) == {(0, 1), (0, 2)}


def test_another_part_has_other_numbers() -> None:
    """Those of the combined seed."""
    assert np.array_equal(Draws(SEEDS, 3).uniform(), Draws(combine(SEEDS, 3)).uniform())


def test_a_scenario_comes_back_from_its_numbers() -> None:
    paper, source = Motor.load("paper"), Chosen(SEEDS)
    drawn = stress_scenarios(paper, source)
    again = stress_scenarios(paper, Chosen(SEEDS, dict(source.units)))
    for field in dataclasses.fields(drawn):
        assert np.array_equal(getattr(drawn, field.name), getattr(again, field.name))
    assert all(np.all((x >= 0.0) & (x < 1.0)) for x in source.units.values())

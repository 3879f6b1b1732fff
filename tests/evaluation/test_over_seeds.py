"""The interval over seeds and scenarios."""

import numpy as np
import pytest

from sensorless.evaluation.evaluate import Scores
from sensorless.evaluation.over_seeds import change_over_seeds, survived
from sensorless.evaluation.rollout import CAUSES


def scores(values: np.ndarray, lost: int = 0, infeasible: int = 0) -> Scores:
    """Of which the first are lost, and the last beyond the machine."""
    gone = np.zeros(len(values), dtype=np.int32)
    gone[:lost] = CAUSES["angle"]
    gone[len(gone) - infeasible :] = CAUSES["angle"] | CAUSES["twin"]
    return Scores(gone, np.ones(len(values)), {"x": values}, {}, {})


def test_what_every_seed_changes_alike_has_no_width() -> None:
    theirs = np.random.default_rng(1).uniform(1.0, 2.0, 400)
    same = change_over_seeds([scores(0.9 * theirs)] * 3, scores(theirs, lost=5), "x")
    assert same == {"change": -10.0, "low": -10.0, "high": -10.0}


def test_what_the_other_loses_does_not_count() -> None:
    """There its values are fifty times as large."""
    theirs = np.random.default_rng(1).uniform(1.0, 2.0, 400)
    wild = np.where(np.arange(400) < 5, 99.0, theirs)
    found = change_over_seeds([scores(0.9 * theirs)] * 3, scores(wild, lost=5), "x")
    assert found["change"] == -10.0


def test_what_the_machine_cannot_do_is_not_lost() -> None:
    """The mean is of the five that survive; there are eight that the machine can do."""
    values = np.array([9.0] * 3 + [1.0, 2.0, 3.0, 4.0, 5.0] + [9.0] * 2)
    found = survived(scores(values, lost=3, infeasible=2), ["x"])
    assert found == {"lost": 3, "of": 8, "x": 3.0}


def test_three_seeds_alone_have_the_interval_of_student() -> None:
    """Mean -10, standard deviation 10: 4.303 times 10 over the root of 3."""
    theirs = np.random.default_rng(1).uniform(1.0, 2.0, 400)
    apart = change_over_seeds([scores(f * theirs) for f in (0.8, 0.9, 1.0)], scores(theirs), "x")
    assert apart["change"] == pytest.approx(-10.0)
    assert apart["high"] - apart["change"] == pytest.approx(4.303 * 10.0 / 3.0**0.5, abs=0.01)


@pytest.mark.parametrize("seeds", [1, 3, 5, 10])
def test_an_interval_holds_the_true_change_in_95_of_100_draws(
    seeds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of -3 %: seeds are 2 % apart, if there are several, and scenarios 30 %."""
    monkeypatch.setattr("sensorless.evaluation.over_seeds.RESAMPLES", 200)
    rng = np.random.default_rng(seeds)
    draws, held = 400, 0
    for _ in range(draws):
        theirs = rng.uniform(1.0, 2.0, 300)
        own = 0.97 + (0.02 * rng.standard_normal(seeds) if seeds > 1 else np.zeros(1))
        ours = [scores(theirs * (x + 0.3 * rng.standard_normal(300))) for x in own]
        found = change_over_seeds(ours, scores(theirs), "x")
        held += found["low"] <= -3.0 <= found["high"]
    assert 0.92 * draws <= held <= 0.99 * draws

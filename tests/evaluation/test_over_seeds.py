"""The interval over seeds and scenarios."""

import numpy as np
import pytest

from sensorless.evaluation.evaluate import Scores
from sensorless.evaluation.over_seeds import contrast


def scores(values: np.ndarray, lost: int = 0) -> Scores:
    gone = np.zeros(len(values), dtype=np.int32)
    gone[:lost] = 1
    return Scores(gone, np.ones(len(values)), {"x": values}, {}, {})


def test_an_interval_covers_seeds_and_scenarios() -> None:
    theirs = np.random.default_rng(1).uniform(1.0, 2.0, 400)
    same = contrast([scores(0.9 * theirs)] * 3, scores(theirs, lost=5), "x")
    assert same == {"change": -10.0, "low": -10.0, "high": -10.0}
    apart = contrast([scores(f * theirs) for f in (0.8, 0.9, 1.0)], scores(theirs), "x")
    assert apart["change"] == pytest.approx(-10.0)
    assert apart["low"] < -15.0 and apart["high"] > -5.0, "the seeds are apart by 10 %"

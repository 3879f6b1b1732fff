"""A rule that brings its own estimator: the same ramp of the speed, another way to the angle."""

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.baselines.rule import Rule, Values, speed
from sensorless.envs.policy import Signals
from sensorless.motor import Motor


class OnEstimator:
    """Linear ramp on a drive whose design has another ``estimator``.

    It has a table, but the table alone would not be it: export the ramp with that design instead.

    Parameters
    ----------
    name : str
    estimator : str
        Of ``DriveDesign``.
    low, high : float
        Band over rated speed [-].
    """

    sensored = False

    def __init__(self, name: str, estimator: str, low: float, high: float) -> None:
        self.name = name
        self.estimator = estimator
        self._table = linear_table(low, high)

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,)."""
        return self._table.evaluate(obs)


def ramp_on(name: str, estimator: str, doc: str) -> Rule:
    """Rule ``name`` with a band as parameters, the paper's by default."""

    def build(word: str, v: Values, motor: Motor) -> OnEstimator:
        return OnEstimator(word, estimator, v["lo"], v["hi"])

    band = (
        speed("lo", EQ25_BAND[0], 0.0, 0.6, "below it injection alone"),
        speed("hi", EQ25_BAND[1], 0.05, 1.5, "above it no injection"),
    )
    return Rule(name, doc, build, band, rising=(("lo", "hi"),))

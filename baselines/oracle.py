"""Greedy oracle: the weight with which the last decision's angle error would have been smallest.

    apart = err_smo - err_hfi
    k_s   = clip((apart err_smo + inertia^2 k_s') / (apart^2 + inertia^2), 0, 1)   with injection
    k_s   = 0 if |err_smo| <= wake, else WAKE_K_S                                  without

err_hfi and err_smo are the true angle minus the estimate, means over the last decision; k_s' is the
weight before. This k_s minimises (err_smo - k_s apart)^2 + inertia^2 (k_s - k_s')^2: without
inertia the weight would jump between 0 and 1 wherever the estimators agree. The oracle knows the
true angle, so it is no deployable rule. It shows what choosing by the angle error alone can reach,
and no more than that: the best choice now need not be the best for the next half second. It runs on
the sliding-mode observer; the coupled one has no second angle to choose.

While there is no injection, the error of its estimator is unknown; WAKE_K_S starts it.
"""

from math import inf

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.core.api import Array
from sensorless.machine.motor import Motor
from sensorless.policy import Settings, Signals

ON_SMO: Settings = {"estimator": "smo"}
WAKE_K_S = 0.01


class Oracle:
    """The rule above; ``act_knowing`` sees the truth.

    Parameters
    ----------
    name : str
    inertia : float
        Distance between the estimators above which the weight moves at once [rad], above 0.
    wake : float
        Error of the observer that wakes the injection [rad].
    """

    sensored = False
    settings: Settings = ON_SMO
    """Of a drive that has two angles to choose from."""

    def __init__(self, name: str, inertia: float, wake: float) -> None:
        self.name = name
        self.inertia, self.wake = inertia, wake
        self._k_s = np.ones(0)

    def reset(self, n: int) -> None:
        """Put n drives on injection."""
        self._k_s = np.ones(n)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Refuse: the signals do not contain the true angle."""
        raise ValueError(f"policy {self.name} needs the true angle; call act_knowing")

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights (n,)."""
        sums = sims["sums"]
        count = np.maximum(sums["n"], 1.0).astype(np.float64)
        err_hfi, err_smo = sums["err_hfi"] / count, sums["err_smo"] / count
        apart = err_smo - err_hfi
        hold = self.inertia**2
        self._k_s = ((apart * err_smo + hold * self._k_s) / (apart**2 + hold)).clip(0.0, 1.0)
        idle = (sums["injecting"] == 0.0) & (sums["n"] > 0.0)
        self._k_s[idle] = np.where(np.abs(err_smo[idle]) > self.wake, WAKE_K_S, 0.0)
        return self._k_s.astype(np.float32)


def _build(name: str, v: Values, motor: Motor) -> Oracle:
    return Oracle(name, np.deg2rad(v["inertia"]), np.deg2rad(v["wake"]))


RULE = Rule(
    "oracle",
    "knows the true angle and takes the weight with the smallest error: greedy, no bound",
    _build,
    (
        Parameter(
            "inertia",
            30.0,
            "deg",
            0.001,
            inf,
            "distance between the estimators that moves the weight",
            search=(1.0, 90.0),
        ),
        Parameter(
            "wake",
            5.0,
            "deg",
            0,
            inf,
            "error of the observer that wakes the injection",
            search=(0.5, 45.0),
        ),
    ),
)

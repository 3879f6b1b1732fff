r"""Reward of ``Blend-v1``: running costs of the last 20 ms, integrated over time.

Weights are per 1 ms and every cost is taken over the same 20 ms, so a return hardly depends on the
decision period if that divides 20 ms and is whole PWM periods: each decision takes one sample of a
cost. A longer one is the window itself. With v a root mean square
over these 20 ms and s its scale below,

    cost = v^2 / (v^2 + s^2)

which is quadratic while small and cannot exceed 1 in a disturbance. Deviations are those from the
sensored twin, so a load step or a ramp, which moves both, costs nothing:

    torque_deviation   v: torque minus the twin's
    torque_ripple      the same about its mean
    speed_deviation    v: mean speed minus the twin's: overshoot and dips that the estimate caused
    angle              v: angle error beyond 20 degrees, as a share of the way to lost lock
    activity           movement of k_s, as its share of the fastest
    injection          share of time with injection on

Near good schedules a percent of ripple counts four times a percent of deviation: with equal weights
an agent that also sets gains buys deviation with ripple. A lost scenario costs a multiple of what a
good schedule pays in one of 2 s, so that losing early does not pay there, but not so
much that one loss in several hundred episodes is all that a learner sees; docs/learning-trials.md
has the figures.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.reward import (
    MOST,
    SCALE_SPEED,
    SCALE_TORQUE,
    RewardWeights,
    Term,
    angle_cost,
)
from sensorless.machine.motor import Motor
from sensorless.settings import number

WINDOW = 0.02
"""Time over which every running cost is taken [s]: the window of the published ripple."""

SCALE_RIPPLE = 0.05
"""Torque ripple at which the cost is one half [rated torque]."""

KEPT = ("n", "dev_sq", "tau", "tau_twin", "omega_m", "omega_m_twin", "err_sq", "k_s_moved",
        "injecting")  # fmt: skip
"""Sums of ``sums_t`` that the costs need."""


@dataclass(frozen=True)
class WindowWeights(RewardWeights):
    """Largest value of each cost; those not named here are as in ``Blend-v0``."""

    torque_deviation: float = number(
        0.050, "1/ms", 0, MOST, "torque minus the sensored twin's over 20 ms"
    )
    torque_ripple: float = number(
        0.025, "1/ms", 0, MOST, "the same difference about its mean over 20 ms"
    )
    angle: float = number(
        0.200, "1/ms", 0, MOST, "angle error of the blend near losing lock: the warning before"
    )
    lost: float = number(200.0, "1", 0, MOST, "once, when lock is lost")


class Window:
    """Sums of n drives over the last 20 ms, or over their life if that is shorter.

    Parameters
    ----------
    n : int
        Drives.
    decision : float
        Time between decisions [s]; the window is the nearest whole number of them.
    """

    def __init__(self, n: int, decision: float) -> None:
        self.kept = np.zeros((max(1, round(WINDOW / decision)), len(KEPT), n))
        """(decisions, sums, n); the oldest is replaced next"""
        self.at = 0

    def add(self, sums: Array) -> None:
        """Take in the sums (n,) of a decision."""
        for j, name in enumerate(KEPT):
            self.kept[self.at, j] = np.nan_to_num(sums[name], nan=1e12, posinf=1e12, neginf=-1e12)
        self.at = (self.at + 1) % len(self.kept)

    def clear(self, rows: NDArray[np.intp]) -> None:
        """Forget the past of some drives."""
        self.kept[:, :, rows] = 0.0

    def ordered(self) -> NDArray[np.float64]:
        """Copy of all sums, oldest first."""
        return np.roll(self.kept, -self.at, axis=0)

    def restore(self, ordered: NDArray[np.float64]) -> None:
        """Continue from such a copy."""
        self.kept[:] = ordered
        self.at = 0

    def totals(self) -> dict[str, NDArray[np.float64]]:
        """Each sum over the window (n,), added from the oldest on."""
        return dict(zip(KEPT, self.ordered().sum(axis=0), strict=True))


def window_terms(
    window: Window, sums: Array, lost: NDArray[np.bool_], weights: WindowWeights, motor: Motor
) -> dict[str, Term]:
    """Terms of the reward of one decision.

    Parameters
    ----------
    window : Window
        It has taken in ``sums``.
    sums : array of ``SIM["sums"]``, shape (n,)
        Sums over the periods of the decision; a drive that did not move earns 0.
    lost : array of bool, shape (n,)
        Drives that lost lock in this decision.
    weights : WindowWeights
    motor : Motor

    Returns
    -------
    dict of str to array of float32, shape (n,)
        One array per name of ``reward.TERMS``, none above 0; the reward is their sum.
    """
    w = window.totals()
    count = np.maximum(w["n"], 1.0)
    dev_sq = w["dev_sq"] / count
    ripple_sq = np.maximum(dev_sq - ((w["tau"] - w["tau_twin"]) / count) ** 2, 0.0)
    speed = (w["omega_m"] - w["omega_m_twin"]) / count
    torque, ripple, omega, moved = _scales(motor)
    costs = {
        "torque_deviation": dev_sq / (dev_sq + torque),
        "torque_ripple": ripple_sq / (ripple_sq + ripple),
        "speed_deviation": speed**2 / (speed**2 + omega),
        "angle": angle_cost(w["err_sq"] / count),
        "activity": np.minimum(w["k_s_moved"] / (count * moved), 1.0),
        "injection": w["injecting"] / count,
    }
    ms = 1e3 * motor.T_s * sums["n"]
    out = {
        name: (-getattr(weights, name) * ms * cost).astype(np.float32)
        for name, cost in costs.items()
    }
    out["lost_penalty"] = np.where(lost, np.float32(-weights.lost), np.float32(0.0))
    return out


@lru_cache(maxsize=8)
def _scales(motor: Motor) -> tuple[float, float, float, float]:
    """Squared scales of torque, ripple and speed, and the fastest movement of k_s in a period.

    Fastest is by default: a design may set another ``k_s_slew``.
    """
    tau = motor.tau_rated
    return (
        (SCALE_TORQUE * tau) ** 2,
        (SCALE_RIPPLE * tau) ** 2,
        (SCALE_SPEED * motor.omega_rated / motor.n_p) ** 2,
        DriveDesign.k_s_slew * motor.T_s,
    )

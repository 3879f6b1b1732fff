"""The objective of training and tuning: one number for a policy on a set of scenarios."""

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
X = TypeVar("X", float, Floats)

LOST_WEIGHT = 10.0
OBJECTIVE = (
    f"{LOST_WEIGHT:g} lost_rate + mean torque_dev_rms + mean torque_ripple_rms "
    "(means over the scenarios survived, shares of rated torque)"
)
"""What training and tuning minimise: losing 1 scenario in 1000 more weighs like 1 % of torque."""
NEAR_SUITE = "unload"
"""Scenarios in which rules that leave injection too early slip, or nearly so."""
NEAR = math.radians(10.0), math.radians(90.0)
"""Angle errors at which a loss begins to come near, and at which it has come. From 15 to 45 degrees
instead, tuned rules pass 15 degrees in up to 1 % of the scenarios, from 10 in hardly more than
injection alone does."""
NEAR_OBJECTIVE = f"{OBJECTIVE} + {LOST_WEIGHT:g} mean nearness of a loss in {NEAR_SUITE}"
"""What tuning a rule minimises: a search ends where losses are rare, which samples do not show."""


def nearness(angle_err: Floats) -> Floats:
    """How near to a loss scenarios came, 0 to 1, by their largest angle errors [rad]; any shape."""
    low, high = NEAR
    return np.clip((angle_err - low) / (high - low), 0.0, 1.0)


def weighted(lost_rate: X, torque_dev: X, torque_ripple: X, ripple: float = 1.0) -> X:
    """Value of ``OBJECTIVE`` with this weight of the ripple: of numbers, or of arrays."""
    return LOST_WEIGHT * lost_rate + torque_dev + ripple * torque_ripple


@dataclass(frozen=True)
class Cost:
    """One policy on a set of scenarios."""

    lost_rate: float
    torque_dev: float
    """Mean ``torque_dev_rms`` of the survived scenarios; 1 if there are none."""
    torque_ripple: float
    """Mean ``torque_ripple_rms`` of the same scenarios."""

    @property
    def objective(self) -> float:
        """Return the value of ``OBJECTIVE``."""
        return self.weighted(1.0)

    def weighted(self, ripple: float) -> float:
        """Return the objective with this weight of the ripple."""
        return weighted(self.lost_rate, self.torque_dev, self.torque_ripple, ripple)


def cost_of(lost: Bools, feasible: Bools, torque_dev: Floats, torque_ripple: Floats) -> Cost:
    """Cost over n scenarios (n,), of which only the feasible ones count.

    Torques count where nothing was lost; if all was, or nothing is feasible, each part is 1.
    """
    kept = feasible & ~lost
    means = (float(x[kept].mean()) if kept.any() else 1.0 for x in (torque_dev, torque_ripple))
    return Cost(float(lost[feasible].mean()) if feasible.any() else 1.0, *means)


@dataclass(frozen=True)
class NearCost(Cost):
    """The same, and how near to a loss the policy comes where loads go."""

    near_loss: float
    """Mean ``nearness`` over scenarios of ``NEAR_SUITE``, 1 of a lost one."""

    def weighted(self, ripple: float) -> float:
        """Return ``NEAR_OBJECTIVE`` with this weight of the ripple."""
        return super().weighted(ripple) + LOST_WEIGHT * self.near_loss

r"""Reward of ``Blend-v0``: the negative cost of a decision, as a sum of named terms.

That of ``Blend-v1`` is in ``window_reward.py``.

Running costs are integrated over time: their weights are per 1 ms, whatever the decision period. A
return still depends on it, since v below is taken over a whole decision: in a longer one a short
peak counts less, and the torque swings further. Of 256 ``stress-1`` under Eq. 25 (seed 11) ripple
costs 0.04 a scenario with decisions of 1 ms and 0.47 with 5 ms, deviation 1.6 (measured once).

Each cost is mapped to 0 ... 1: with v the root mean square over the decision (of the speed, its
mean) and s its scale below,

    cost = v^2 / (v^2 + s^2)

which is quadratic while small, as the metrics are, and cannot exceed 1 in a disturbance. Activity
is v / (v + s) with v the movement of k_s; injection is its share of the time. The angle costs
nothing up to an error that a loaded drive lives with, and beyond it the square of the share of the
way to lost lock: few scenarios are lost, but many come near, and those show an agent where the
danger is. So no decision costs more than ``RewardWeights.worst_running`` per 1 ms.

The weights are chosen so that, near good schedules and with decisions of 5 ms, torque deviation and
ripple are worth about the same relative to each other as in ``objective.OBJECTIVE``. With the
default of 1 ms ripple hardly counts: give ``decision_period`` [s], or take Blend-v1.

Losing lock ends an episode and with it all running costs. It must never pay to lose lock early, so
the penalty exceeds the worst running costs of 929 ms, and those of a whole scenario of 2 s without
the angle's cost, which only counts on the way to losing lock.
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG
from sensorless.machine.motor import Motor
from sensorless.settings import check, number

Term = NDArray[np.float32]
Floats = NDArray[Any]
"""float32 or float64"""


SCALE_TORQUE = 0.20
"""Torque deviation at which the cost is one half [rated torque]."""
SCALE_RIPPLE = 0.02
"""Torque ripple at which the cost is one half [rated torque]."""
SCALE_SPEED = 0.05
"""Speed deviation at which the cost is one half [rated speed]."""
ANGLE_FREE = math.radians(20.0)
"""Largest angle error without cost [rad]; steady errors of a loaded drive are smaller."""
ANGLE_LOST = math.radians(LOST_ANGLE_DEG)
"""Angle error at which the cost is one [rad]; beyond it, lock counts as lost."""
MOST = 1e6
"""Largest weight: a reward is a float32, and should be finite."""
SCALE_ACTIVITY = 0.05
"""Movement of k_s in 1 ms at which the cost is one half."""


@dataclass(frozen=True)
class RewardWeights:
    """Largest value of each cost."""

    torque_deviation: float = number(
        0.050, "1/ms", 0, MOST, "torque minus the sensored twin's, without the injection band"
    )
    torque_ripple: float = number(
        0.0045, "1/ms", 0, MOST, "swing of the torque in a decision, without the injection band"
    )
    speed_deviation: float = number(
        0.020,
        "1/ms",
        0,
        MOST,
        "speed minus the twin's: overshoot and dips that the estimate caused",
    )
    angle: float = number(
        1.0, "1/ms", 0, MOST, "angle error of the blend near losing lock: the warning before"
    )
    activity: float = number(0.001, "1/ms", 0, MOST, "movement of k_s")
    injection: float = number(0.0002, "1/ms", 0, MOST, "share of time with injection on")
    lost: float = number(1000.0, "1", 0, MOST, "once, when lock is lost")

    def __post_init__(self) -> None:
        """Check every weight.

        Raises
        ------
        UserError
            Names the weight, its value and what it must be.
        """
        check(self, "reward weight ")

    @property
    def worst_running(self) -> float:
        """Upper bound of all running costs together per 1 ms."""
        return float(sum(dataclasses.astuple(self))) - self.lost


TERMS = (*(f.name for f in dataclasses.fields(RewardWeights) if f.name != "lost"), "lost_penalty")
"""Names of the terms, in the order in which they are added."""
MEANS = ("torque_deviation", "angle", "activity", "speed_deviation")
"""Running costs of what is a mean over the periods of the decision."""
ROWS = (*MEANS, "torque_ripple")
"""Running costs that share a formula: rows of one array, so that each step is one call of numpy."""
SQUARED = ("speed_deviation", "torque_ripple")
"""Those whose value the core does not give as a square."""


@np.errstate(over="ignore", invalid="ignore")
def terms(
    sums: Array, lost: NDArray[np.bool_], weights: RewardWeights, motor: Motor
) -> dict[str, Term]:
    """Terms of the reward of one decision.

    Parameters
    ----------
    sums : array of ``SIM["sums"]``, shape (n,)
        Sums over the periods of the decision; a drive that did not move earns 0.
    lost : array of bool, shape (n,)
        Drives that lost lock in this decision.
    weights : RewardWeights
    motor : Motor
        Rated values and the PWM period.

    Returns
    -------
    dict of str to array of float32, shape (n,)
        One array per name of ``TERMS``, none above 0; the reward is their sum.
    """
    n = sums["n"]
    x = np.empty((len(ROWS), len(n)), dtype=np.float32)
    row = dict(zip(ROWS, x, strict=True))
    row["torque_deviation"][:] = sums["dev_lf_sq"]
    row["angle"][:] = sums["err_sq"]
    row["activity"][:] = sums["k_s_moved"]
    np.subtract(sums["omega_m"], sums["omega_m_twin"], out=row["speed_deviation"])
    np.subtract(sums["tau_max"], sums["tau_min"], out=row["torque_ripple"])
    x[: len(MEANS)] /= np.maximum(n, np.float32(1.0))
    for name in SQUARED:
        row[name] *= row[name]
    np.fmin(x, np.float32(1e12), out=x)  # also replaces the NaN of a broken state by a number

    weight, scale, ms = _constants(weights, motor)
    angle = angle_cost(row["angle"])
    x /= x + scale
    row["angle"][:] = angle
    x *= weight
    x *= ms * n
    row["injection"] = np.float32(-weights.injection) * ms * sums["injecting"]
    row["lost_penalty"] = np.zeros(len(n), dtype=np.float32)
    row["lost_penalty"][lost] = -weights.lost
    return {name: row[name] for name in TERMS}


def angle_cost(err_sq: Floats) -> Floats:
    """Cost (n,) of an angle error, 0 to 1, from its mean square over time [rad^2]."""
    above = (np.sqrt(err_sq) - ANGLE_FREE) / (ANGLE_LOST - ANGLE_FREE)
    cost: Floats = np.clip(above, 0.0, 1.0) ** 2
    return cost


def total(parts: dict[str, Term]) -> Term:
    """Reward: the sum of the terms, added in the order of ``TERMS``."""
    reward = parts[TERMS[0]] + parts[TERMS[1]]
    for name in TERMS[2:]:
        reward += parts[name]
    return reward


@lru_cache(maxsize=8)
def _constants(weights: RewardWeights, motor: Motor) -> tuple[Array, Array, np.float32]:
    """Negative weights and scales of `ROWS`, both (5, 1), and a period in ms.

    The peak-to-peak swing of a sine is sqrt(8) times its root mean square.
    """
    ms = 1e3 * motor.T_s
    pairs = {
        "torque_deviation": (weights.torque_deviation, (SCALE_TORQUE * motor.tau_rated) ** 2),
        "angle": (weights.angle, ANGLE_LOST**2),
        "activity": (weights.activity, SCALE_ACTIVITY * ms),
        "speed_deviation": (
            weights.speed_deviation,
            (SCALE_SPEED * motor.omega_rated / motor.n_p) ** 2,
        ),
        "torque_ripple": (weights.torque_ripple, 8.0 * (SCALE_RIPPLE * motor.tau_rated) ** 2),
    }
    columns = np.array([pairs[name] for name in ROWS], dtype=np.float32).T[:, :, None]
    return -columns[0], columns[1], np.float32(ms)

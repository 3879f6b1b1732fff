import dataclasses

import numpy as np
import pytest

from sensorless.core.api import SIM
from sensorless.envs.reward import (
    ANGLE_FREE,
    ANGLE_LOST,
    SCALE_ACTIVITY,
    SCALE_RIPPLE,
    SCALE_SPEED,
    SCALE_TORQUE,
    TERMS,
    RewardWeights,
    terms,
    total,
)
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
WEIGHTS = RewardWeights()
NOBODY = np.zeros(3, dtype=bool)


def zero_sums(periods: int = 5) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    sums = np.zeros(3, dtype=SIM["sums"])
    sums["n"] = periods
    return sums


def test_losing_lock_costs_more_than_the_worst_that_could_follow() -> None:
    assert WEIGHTS.lost >= 929.0 * WEIGHTS.worst_running
    assert WEIGHTS.worst_running == pytest.approx(1.0757)
    assert WEIGHTS.lost >= 2000.0 * (WEIGHTS.worst_running - WEIGHTS.angle)


def test_a_perfect_decision_costs_nothing() -> None:
    parts = terms(zero_sums(), NOBODY, WEIGHTS, MOTOR)
    assert tuple(parts) == TERMS
    assert all(not part.any() for part in parts.values())


def test_every_scale_is_where_its_cost_is_half() -> None:
    sums = zero_sums()
    swing = np.sqrt(8.0) * SCALE_RIPPLE * MOTOR.tau_rated
    sums["tau_min"], sums["tau_max"] = 3.0, 3.0 + swing
    sums["dev_lf_sq"] = 5 * (SCALE_TORQUE * MOTOR.tau_rated) ** 2
    sums["omega_m"] = 5 * (10.0 + SCALE_SPEED * MOTOR.omega_rated / MOTOR.n_p)
    sums["omega_m_twin"] = 5 * 10.0
    sums["k_s_moved"] = 5 * SCALE_ACTIVITY * 1e3 * MOTOR.T_s
    parts = terms(sums, NOBODY, WEIGHTS, MOTOR)
    for name in ("torque_deviation", "torque_ripple", "speed_deviation", "activity"):
        assert parts[name] == pytest.approx(-0.5 * getattr(WEIGHTS, name), rel=1e-4)


def test_the_angle_costs_from_where_danger_begins() -> None:
    sums = zero_sums()
    sums["err_sq"] = (
        5 * np.array([ANGLE_FREE, 0.5 * (ANGLE_FREE + ANGLE_LOST), 2 * ANGLE_LOST]) ** 2
    )
    cost = -terms(sums, NOBODY, WEIGHTS, MOTOR)["angle"] / WEIGHTS.angle
    np.testing.assert_allclose(cost, [0.0, 0.25, 1.0], atol=1e-6)


def test_costs_follow_time_not_decisions() -> None:
    """A decision of 10 periods costs twice one of 5 under the same disturbance; none costs 0."""
    sums = zero_sums()
    sums["n"] = (5, 10, 0)
    sums["dev_lf_sq"] = 4.0 * sums["n"]
    sums["injecting"] = sums["n"]
    parts = terms(sums, NOBODY, WEIGHTS, MOTOR)
    for name in ("torque_deviation", "injection"):
        assert parts[name][1] == pytest.approx(2.0 * parts[name][0])
        assert parts[name][2] == 0.0
    assert parts["injection"][0] == pytest.approx(-WEIGHTS.injection)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("value", [1e30, np.inf, np.nan])
def test_a_broken_state_costs_no_more_than_the_worst(value: float) -> None:
    sums = zero_sums()
    for name in SIM["sums"].names or ():
        if name not in ("n", "injecting"):
            sums[name] = value
    sums["injecting"] = sums["n"]
    parts = terms(sums, np.array([True, False, True]), WEIGHTS, MOTOR)
    reward = total(parts)
    assert np.all(reward[[0, 2]] <= -WEIGHTS.lost)
    running = reward - parts["lost_penalty"]
    assert np.all(np.isfinite(reward)) and np.all(running >= -1.001 * WEIGHTS.worst_running)


@pytest.mark.parametrize("name", [f.name for f in dataclasses.fields(RewardWeights)])
def test_bad_weight_is_named(name: str) -> None:
    with pytest.raises(UserError, match=f"{name}: nan: must be"):
        RewardWeights(**{name: float("nan")})
    with pytest.raises(UserError, match=f"{name}: -1: must be between 0 and 1000000"):
        RewardWeights(**{name: -1})
    with pytest.raises(UserError, match=r"1e\+39: must be between"):
        RewardWeights(**{name: 1e39})

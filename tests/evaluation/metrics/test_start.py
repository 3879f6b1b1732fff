"""Metrics of starts against numbers by hand."""

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIM
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.evaluation.metrics.start import backward_excess_pct, start_err_deg, start_s
from sensorless.evaluation.rollout import Rollout
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
P = 5
"""Periods of a decision."""


def made_up(starting: int, decisions: int = 40, target: float = 0.2, **sums: object) -> Rollout:
    """One drive from rest, asked for ``target`` of rated, whose sequence takes so many periods."""
    scenarios = Scenarios.nominal(MOTOR, np.array([1], dtype=np.uint64), decisions * P * MOTOR.T_s)
    scenarios.omega[:] = target * RATED
    rows = np.zeros((decisions, 1), dtype=SIM["sums"])
    rows["n"] = P
    rows["starting"][:, 0] = np.clip(starting - P * np.arange(decisions), 0, P)
    for name, values in sums.items():
        rows[name][:, 0] = values
    lived = np.array([decisions * P], dtype=np.int64)
    return Rollout(MOTOR, scenarios, rows, np.zeros(1, dtype=np.int32), lived)


def speeds(*of_rated: float) -> NDArray[np.float64]:
    """Sums of 40 decisions that hold these speeds in turn."""
    return np.repeat(of_rated, 40 // len(of_rated)) * RATED * P


def test_length_of_the_sequence() -> None:
    assert start_s(made_up(33))[0] == pytest.approx(33 * MOTOR.T_s)
    assert np.isnan(start_s(made_up(0))[0])


@pytest.mark.parametrize(
    ("at", "seen"), [(5, False), (6, True), (12, True), (17, True), (18, False)]
)
def test_the_angle_is_judged_for_ten_milliseconds(at: int, seen: bool) -> None:
    """A sequence of 33 periods ends within decision 6."""
    err_max = np.full(40, np.deg2rad(2.0))
    err_max[at] = np.pi
    assert start_err_deg(made_up(33, err_max=err_max))[0] == pytest.approx(180.0 if seen else 2.0)


def test_no_angle_without_a_sequence_or_its_end() -> None:
    assert np.isnan(start_err_deg(made_up(0, err_max=1.0))[0])
    assert np.isnan(start_err_deg(made_up(40 * P, err_max=1.0))[0])


@pytest.mark.parametrize(
    ("target", "drive", "twin", "excess"),
    [
        (0.2, (0.0, -0.05, 0.2, 0.2), (0.0, -0.02, 0.2, 0.2), 3.0),
        (-0.2, (0.0, 0.05, -0.2, -0.2), (0.0, 0.02, -0.2, -0.2), 3.0),
        (0.2, (0.0, 0.1, 0.2, 0.2), (0.0, 0.1, 0.2, 0.2), 0.0),
        (0.2, (0.0, 0.1, 0.2, 0.2), (0.0, -0.1, 0.2, 0.2), -10.0),
    ],
)
def test_backwards_is_against_the_target_and_beyond_the_twin(
    target: float, drive: tuple[float, ...], twin: tuple[float, ...], excess: float
) -> None:
    r = made_up(33, target=target, omega_m=speeds(*drive), omega_m_twin=speeds(*twin))
    assert backward_excess_pct(r)[0] == pytest.approx(excess, abs=1e-4)


def test_the_wanted_direction_is_that_of_the_last_target_in_time() -> None:
    """Backward in the second half; forward again only after the end."""
    r = made_up(33, omega_m=speeds(0.0, 0.05, -0.2, -0.2), omega_m_twin=speeds(0.0, 0.0))
    end = 40 * P * MOTOR.T_s
    r.scenarios.t[0, 1], r.scenarios.t[0, 2] = 0.5 * end, 1.5 * end
    r.scenarios.omega[0, 1], r.scenarios.omega[0, 2:] = -0.2 * RATED, 0.2 * RATED
    assert backward_excess_pct(r)[0] == pytest.approx(5.0, abs=1e-4)


def test_backwards_has_no_meaning_without_a_direction() -> None:
    assert np.isnan(backward_excess_pct(made_up(33, target=0.0))[0])
    spinning = made_up(33)
    spinning.scenarios.omega_0[:] = 1.0
    assert np.isnan(backward_excess_pct(spinning)[0])

"""Metrics against closed forms, on rollouts made up period by period."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.evaluation.metrics.catalogue import (
    METRICS,
    angle_err_max_deg,
    angle_err_mean_deg,
    angle_err_p999_deg,
    angle_err_rms_deg,
    copper_extra,
    injection_share,
    k_s_activity,
    speed_dev_rms,
    torque_dev_lf_rms,
    torque_dev_rms,
)
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
P = 5
"""Periods of a decision."""

Floats = NDArray[np.float64]


def made_up(periods: int, live: int | None = None, **signals: ArrayLike) -> Rollout:
    """One drive that shows these signals period by period, and lives for ``live`` periods.

    A signal is a field of ``sums_t`` that is summed as it is; ``dev`` fills its own squares.
    """
    live = periods if live is None else live
    rows = {
        name: np.broadcast_to(np.asarray(x, dtype=np.float64), periods).copy()
        for name, x in signals.items()
    }
    dev = rows.pop("dev", np.zeros(periods))
    rows["dev_sq"] = dev**2
    rows["dev_lf_sq"] = (0.5 * (dev + np.concatenate([dev[:1], dev[:-1]]))) ** 2
    rows["n"] = np.ones(periods)
    sums = np.zeros((-(-periods // P), 1), dtype=SIM["sums"])
    fold: dict[str, Callable[[Floats], float]] = {"err_max": np.max}
    for name, x in rows.items():
        for j in range(-(-live // P)):
            part = x[j * P : min((j + 1) * P, live)]
            sums[name][j, 0] = fold.get(name, np.sum)(part)
    scenario = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), periods * MOTOR.T_s)
    lost = np.array([int(live < periods)], dtype=np.int32)
    return Rollout(MOTOR, scenario, sums, lost, np.array([live]))


def test_torque_deviation() -> None:
    r = made_up(1000, dev=np.where(np.arange(1000) < 500, 0.7, -2.1))
    expected = np.sqrt((0.7**2 + 2.1**2) / 2.0) / 14.0
    assert torque_dev_rms(r)[0] == pytest.approx(expected, rel=1e-6)


def test_the_injection_band_is_left_out_of_lf_metrics() -> None:
    r = made_up(1000, dev=np.where(np.arange(1000) % 2, 1.4, -1.4))
    assert torque_dev_rms(r)[0] == pytest.approx(0.1, rel=1e-6)
    assert torque_dev_lf_rms(r)[0] == pytest.approx(0.0, abs=0.004)


def test_angle_error() -> None:
    err = np.repeat(np.deg2rad([8.0, -4.0]), [250, 750])
    r = made_up(1000, err=err, err_sq=err**2, err_max=np.abs(err))
    assert angle_err_mean_deg(r)[0] == pytest.approx(-1.0, rel=1e-5)
    assert angle_err_rms_deg(r)[0] == pytest.approx(np.sqrt(28.0), rel=1e-6)
    assert angle_err_max_deg(r)[0] == pytest.approx(8.0, rel=1e-6)


@pytest.mark.parametrize(("live", "rank"), [(10_000, 1998), (5_000, 999), (50, 10)])
def test_the_bound_of_99_9_percent(live: int, rank: int) -> None:
    worst = np.repeat(np.deg2rad(np.arange(1, 2001) / 100.0), P)
    rng = np.random.default_rng(3)
    order = rng.permutation(live // P)
    worst[:live] = worst[:live].reshape(-1, P)[order].ravel()
    r = made_up(10_000, live, err_max=worst)
    assert angle_err_p999_deg(r)[0] == pytest.approx(rank / 100.0, rel=1e-5)


def test_speed_deviation() -> None:
    r = made_up(1000, omega_m=100.0, omega_m_twin=100.0 - 0.02 * RATED)
    assert speed_dev_rms(r)[0] == pytest.approx(0.02, rel=1e-4)


def test_costs() -> None:
    i_sq = np.where(np.arange(1000) < 500, 5.0**2, 3.0**2)
    steps = np.zeros(1000)
    steps[[100, 400]] = 0.6, 0.9
    r = made_up(1000, i_sq=i_sq, i_sq_twin=4.0**2, injecting=np.arange(1000) < 300, k_s_moved=steps)
    assert copper_extra(r)[0] == pytest.approx((17.0 - 16.0) / 5.63**2, rel=1e-5)
    assert injection_share(r)[0] == pytest.approx(0.3)
    assert k_s_activity(r)[0] == pytest.approx(1.5 / 0.2, rel=1e-5)


def test_only_the_life_of_a_drive_counts() -> None:
    late = np.arange(1000) >= 402
    r = made_up(
        1000,
        402,
        dev=np.where(late, 99.0, 1.4),
        err_max=np.where(late, 3.0, 0.1),
        injecting=~late,
        omega_m=np.where(late, 0.0, 50.0),
        omega_m_twin=50.0,
    )
    assert torque_dev_rms(r)[0] == pytest.approx(0.1, rel=1e-6)
    assert angle_err_max_deg(r)[0] == pytest.approx(np.rad2deg(0.1), rel=1e-6)
    assert injection_share(r)[0] == pytest.approx(1.0)
    assert speed_dev_rms(r)[0] == 0.0


def test_a_drive_without_a_period_has_no_metrics() -> None:
    r = made_up(100, 0)
    for name, metric in METRICS.items():
        assert np.isnan(metric(r)).all(), name


class Half:
    """Both estimators at equal weight."""

    name = "half"
    sensored = False
    settings: Settings = NO_SETTINGS

    def reset(self, n: int) -> None:
        pass

    def act(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.full(len(obs), 0.5, dtype=np.float32)


def test_metrics_of_a_drive_are_its_own_whatever_runs_beside_it() -> None:
    scenarios = stress_1_scenarios(MOTOR, np.arange(5, dtype=np.uint64))
    scenarios.duration[:] = [0.4, 0.5, 0.3, 0.5, 0.2]
    factory = SimFactory(MOTOR, DriveDesign())
    together = rollout(Half(), scenarios, factory)
    for j in range(5):
        alone = rollout(Half(), scenarios[j : j + 1], factory)
        for name, metric in METRICS.items():
            beside, own = metric(together)[j], metric(alone)[0]
            np.testing.assert_allclose(beside, own, rtol=1e-12, atol=1e-15, err_msg=name)


def test_every_metric_says_what_it_is() -> None:
    for name, metric in METRICS.items():
        assert metric.__name__ == name
        assert metric.__doc__, name

"""Torque ripple against closed forms, on torques made up period by period, and on real drives."""

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.metrics.ripple import (
    HANDOVER,
    in_handover,
    torque_p2p_handover,
    torque_p2p_window,
    torque_ripple_lf_rms,
    torque_ripple_rms,
    torque_ripple_window,
)
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
P = 5
"""Periods of a decision."""

Floats = NDArray[np.float64]


def drive(
    tau: ArrayLike,
    twin: ArrayLike = 0.0,
    *,
    speed: ArrayLike = 0.25,
    k_s: ArrayLike = 0.5,
    live: int = 10**9,
) -> Rollout:
    """One drive with these torques of its own and of its twin [N m], period by period.

    ``speed`` is the twin's, over the rated one.
    """
    tau = np.asarray(tau, dtype=np.float64)
    twin = np.broadcast_to(np.asarray(twin, dtype=np.float64), tau.shape)
    live = min(live, len(tau))
    pairs = [0.5 * (x + np.concatenate([x[:1], x[:-1]])) for x in (tau, tau - twin)]
    rows = {
        "tau": tau,
        "tau_sq": tau**2,
        "tau_lf_sq": pairs[0] ** 2,
        "tau_twin": twin,
        "dev_lf_sq": pairs[1] ** 2,
        "omega_m_twin": RATED * np.broadcast_to(np.asarray(speed, dtype=np.float64), tau.shape),
        "k_s": np.broadcast_to(np.asarray(k_s, dtype=np.float64), tau.shape),
        "n": np.ones(len(tau)),
    }
    parts = -(-len(tau) // P)
    alive = np.arange(parts * P).reshape(parts, P) < live

    def split(x: Floats) -> Floats:
        return np.pad(x, (0, parts * P - len(x))).reshape(parts, P)

    sums = np.zeros((parts, 1), dtype=SIM["sums"])
    for name, x in rows.items():
        sums[name][:, 0] = np.sum(split(x), axis=1, where=alive)
    some = alive.any(axis=1)
    sums["tau_min"][some, 0] = np.min(split(pairs[0]), axis=1, where=alive, initial=np.inf)[some]
    sums["tau_max"][some, 0] = np.max(split(pairs[0]), axis=1, where=alive, initial=-np.inf)[some]
    scenario = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), len(tau) * MOTOR.T_s)
    lost = np.array([int(live < len(tau))], dtype=np.int32)
    return Rollout(MOTOR, scenario, sums, lost, np.array([live]))


def exact_ripple(tau: Floats) -> float:
    """RMS of torque minus its centred 20 ms moving mean, sample by sample, over rated torque."""
    h = 50
    weights = np.ones(2 * h + 1)
    weights[[0, -1]] = 0.5
    total, count = (np.convolve(x, weights)[h:-h] for x in (tau, np.ones_like(tau)))
    mean = total / count
    return float(np.sqrt(np.mean((tau - mean) ** 2)) / MOTOR.tau_rated)


def noisy(periods: int, seed: int) -> Floats:
    """Torque of a slow and a fast wave, and noise [N m]."""
    rng = np.random.default_rng(seed)
    t = np.arange(periods) * MOTOR.T_s
    tau = 4.0 * np.sin(2.0 * np.pi * 7.0 * t) + np.cos(2.0 * np.pi * 90.0 * t)
    return np.asarray(tau + 0.3 * rng.standard_normal(periods))


def test_the_injection_band_is_left_out() -> None:
    r = drive(3.0 + np.where(np.arange(1000) % 2, 1.4, -1.4))
    assert torque_ripple_rms(r)[0] == pytest.approx(0.1, rel=1e-3)
    assert torque_ripple_lf_rms(r)[0] == pytest.approx(0.0, abs=0.006)
    assert torque_ripple_window(r)[0] == pytest.approx(0.0, abs=0.006)


@pytest.mark.parametrize("cycles", [1, 2, 3])
def test_ripple_of_whole_cycles_in_the_window_is_their_rms(cycles: int) -> None:
    t = np.arange(10_000) * MOTOR.T_s
    r = drive(5.0 + 0.7 * np.sin(2.0 * np.pi * cycles * t / 0.02))
    assert torque_ripple_rms(r)[0] == pytest.approx(0.05 / np.sqrt(2.0), rel=0.01)
    assert torque_ripple_window(r)[0] == pytest.approx(0.05 / np.sqrt(2.0), rel=0.01)


def test_constant_torque_and_a_slow_ramp_are_no_ripple() -> None:
    assert torque_ripple_rms(drive(np.full(5000, 14.0)))[0] == pytest.approx(0.0, abs=2e-4)
    assert torque_ripple_rms(drive(np.linspace(-14.0, 14.0, 5000)))[0] < 0.003


@pytest.mark.parametrize("periods", [40, 333, 4000])
def test_ripple_is_that_of_every_period(periods: int) -> None:
    tau = noisy(periods, periods)
    assert torque_ripple_rms(drive(tau))[0] == pytest.approx(exact_ripple(tau), rel=0.02)


def test_ripple_ends_with_the_drive() -> None:
    tau = np.where(np.arange(1000) < 703, 6.0, 600.0)
    for metric in (torque_ripple_rms, torque_ripple_window):
        assert metric(drive(tau, live=703))[0] == pytest.approx(0.0, abs=2e-4)


def test_peak_to_peak_counts_only_between_the_estimators() -> None:
    tau = np.zeros(3000)
    tau[500:600] = 1.4
    tau[2000:2100] = 2.8
    k_s = np.where(np.arange(3000) < 1500, 0.5, 0.0)
    assert torque_p2p_handover(drive(tau, k_s=k_s))[0] == pytest.approx(0.1)
    assert torque_p2p_handover(drive(tau))[0] == pytest.approx(0.2)
    assert np.isnan(torque_p2p_handover(drive(tau, k_s=1.0))[0])
    for end, inside in ((0.00095, 0.00105), (0.99905, 0.99895)):
        assert np.isnan(torque_p2p_handover(drive(tau, k_s=end))[0])
        assert torque_p2p_handover(drive(tau, k_s=inside))[0] == pytest.approx(0.2)


def test_peak_to_peak_looks_no_further_than_20_ms() -> None:
    slow = drive(np.linspace(0.0, 14.0, 5000))
    assert torque_p2p_handover(slow)[0] == pytest.approx(0.021, rel=0.03)
    assert torque_p2p_window(slow)[0] == pytest.approx(0.020, rel=0.03)


def test_what_the_twin_does_too_is_no_ripple_of_the_window() -> None:
    tau = noisy(4000, 1)
    tau[2000:] += 14.0
    both = drive(tau, tau)
    assert torque_ripple_window(both)[0] == 0.0
    assert torque_p2p_window(both)[0] == 0.0
    ripple = 0.7 * np.sin(2.0 * np.pi * 100.0 * np.arange(4000) * MOTOR.T_s)
    assert torque_ripple_window(drive(tau + ripple, tau))[0] == pytest.approx(
        exact_ripple(ripple), rel=0.02
    )


def test_the_window_is_where_the_twin_is_whatever_the_weight() -> None:
    t = np.arange(4000)
    speed = np.select([t < 1000, t < 2000, t < 3000], [0.1, 0.25, -0.25], 0.4)
    tau = np.select([t < 1000, t < 2000, t < 3000], [7.0, 1.4, 0.7], 14.0) * np.where(
        t // 25 % 2, 1.0, 0.0
    )
    tau[(t > 880) & (t < 1120) | (t > 2880) & (t < 3120)] = 0.0
    for k_s in (0.0, 1.0):
        r = drive(tau, speed=speed, k_s=k_s)
        assert in_handover(r)[:, 0].sum() == 400
        assert torque_p2p_window(r)[0] == pytest.approx(0.1, rel=1e-6)
        assert 0.02 < torque_ripple_window(r)[0] < 0.06


def test_peak_to_peak_in_the_window_leaves_the_injection_out() -> None:
    tau = np.where(np.arange(4000) % 2, 7.0, -7.0)
    tau[2000:] += 1.4
    assert torque_p2p_window(drive(tau[10:]))[0] == pytest.approx(0.1, rel=1e-5)


@pytest.mark.parametrize(
    ("k_s", "between"), [(0.0009, False), (0.0011, True), (0.9989, True), (0.9991, False)]
)
def test_a_drive_between_its_estimators(k_s: float, between: bool) -> None:
    """Each 7 N m with a step of 1.4; that it ends at 7 N m is none."""
    tau = np.where(np.arange(1000) < 200, 5.6, 7.0)
    found = torque_p2p_handover(drive(tau, k_s=k_s, live=600))[0]
    assert found == pytest.approx(0.1, rel=1e-6) if between else np.isnan(found)


def test_the_window_is_from_17_to_32_percent_of_rated_speed() -> None:
    tau = np.zeros(100)
    for speed, inside in ((0.168, False), (0.172, True), (0.318, True), (0.322, False)):
        assert in_handover(drive(tau, speed=speed)).all() == inside
        assert in_handover(drive(tau, speed=-speed)).all() == inside


def test_a_drive_that_never_came_there_has_no_ripple_of_the_window() -> None:
    for speed in (0.99 * HANDOVER[0], 1.01 * HANDOVER[1]):
        r = drive(noisy(1000, 2), speed=speed)
        assert np.isnan(torque_ripple_window(r)[0])
        assert np.isnan(torque_p2p_window(r)[0])


def test_the_window_tells_a_hard_switch_from_a_blend_and_a_drive_from_its_twin() -> None:
    """Where the estimators differ, by a low L_q as a motor; else a hard switch is no worse."""
    scenarios = suite("handoff", MOTOR, 3, 16)
    factory = SimFactory(MOTOR, DriveDesign(estimator="smo", L_q_motoring=0.7))
    found = {
        name: rollout(make_policy(name, MOTOR), scenarios, factory)
        for name in ("sensored", "eq25", "hysteresis")
    }
    for metric in (torque_ripple_window, torque_p2p_window):
        assert np.all(metric(found["sensored"]) == 0.0)
        assert np.all(metric(found["eq25"]) > 0.0)
        assert np.mean(metric(found["hysteresis"])) > 1.1 * np.mean(metric(found["eq25"]))
    same = {name: in_handover(r) for name, r in found.items()}
    np.testing.assert_array_equal(same["eq25"], same["hysteresis"])

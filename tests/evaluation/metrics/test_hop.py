"""Hopping of k_s: closed forms on made-up weights, and shipped schedules that do and do not."""

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.metrics.hop import HOP, hops, k_s_hop
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
TIME = (np.arange(3000) + 0.5) * 1e-3
Floats = NDArray[np.float64]


def made_up(k_s: Floats, twin: float | Floats = 0.0, live: int = 15_000) -> Rollout:
    """Standstill for 3 s, load step at 1 s; a drive with these weights and twin's speeds."""
    s = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), 3.0)
    s.t[0, 1], s.tau[0, 1:] = 1.0, MOTOR.tau_rated
    sums = np.zeros((len(k_s), 1), dtype=SIM["sums"])
    sums["n"][:, 0] = np.clip(live - 5 * np.arange(len(k_s)), 0, 5)
    sums["k_s"], sums["omega_m_twin"] = 5.0 * k_s[:, None], 5.0 * RATED * np.c_[twin]
    return Rollout(MOTOR, s, sums, np.zeros(1, dtype=np.int32), np.array([live]))


@pytest.mark.parametrize("hz", [0.6, 5.0, 40.0])
def test_a_weight_that_swings_shows_its_peak_to_peak(hz: float) -> None:
    for swing, hopping in ((0.04, 0.0), (0.06, 1.0), (0.3, 1.0)):
        r = made_up(0.5 + 0.5 * swing * np.sin(2.0 * np.pi * hz * TIME))
        assert k_s_hop(r)[0] == pytest.approx(swing, rel=0.03)
        assert hops(r)[0] == hopping


def test_a_weight_that_creeps_up_hops_by_all_of_its_way() -> None:
    """For 1.5 s by 0.2 a second, without a change since 1 s."""
    creeps = 0.2 + 0.2 * np.maximum(TIME - 1.5, 0.0)
    assert k_s_hop(made_up(creeps))[0] == pytest.approx(0.3, abs=1e-3)


def test_what_follows_a_change_is_no_hop() -> None:
    step = np.where(TIME > 1.2, 0.2, 0.9)
    assert k_s_hop(made_up(step))[0] == 0.0
    before = np.where(TIME > 0.6, 0.2, 0.9)
    assert k_s_hop(made_up(before))[0] == pytest.approx(0.7), "the rest after 1 s is without any"
    late = np.where(TIME > 1.5, 0.2, 0.9)
    assert k_s_hop(made_up(late))[0] == pytest.approx(0.7)


@pytest.mark.parametrize(("off", "rest"), [(0.0019, True), (0.0021, False)])
def test_rest_is_within_a_five_hundredth_of_rated_speed(off: float, rest: bool) -> None:
    step = np.where(TIME > 1.5, 0.2, 0.9)
    for way in (-off, off):
        assert np.isfinite(k_s_hop(made_up(step, twin=way))[0]) == rest


def test_no_rest_while_the_twin_moves_or_after_the_end() -> None:
    wave = np.sin(40.0 * TIME)
    assert np.isnan(k_s_hop(made_up(wave, twin=0.01))[0])
    assert np.isnan(hops(made_up(wave, twin=0.01))[0])
    settled = np.where(TIME < 2.0, 0.01, 0.001)
    r = made_up(np.where(TIME < 2.0, wave, 0.5), twin=settled)
    assert k_s_hop(r)[0] == 0.0
    assert k_s_hop(made_up(np.where(TIME > 2.5, wave, 0.5), live=12_400))[0] == 0.0


@pytest.mark.parametrize(("policy", "still"), [("reference", True), ("reference-flux", False)])
def test_schedules_under_rated_load_at_standstill(policy: str, still: bool) -> None:
    """The torque current changes its sign with the noise of the speed."""
    made = make_policy(policy, MOTOR)
    load = SuiteRows("handoff", MOTOR, 11, 52)[44:46].draw()
    r = rollout(made, load, SimFactory(MOTOR, DriveDesign()))
    assert (k_s_hop(r) < HOP).all() if still else (k_s_hop(r) > 0.2).all()

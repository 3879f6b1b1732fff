"""Drives that lose lock, and what they do then, in blocks as in the plain loop."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.core.gains import DEFAULT, gain_records
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.motor import Motor

PERIODS = 1500
N = 32


def nervous(go_on: bool) -> Array:
    """Drives of which some raise an alarm, start again, or stop; the others hold."""
    motor = Motor.load("paper")
    sims = SimFactory(motor, DriveDesign(estimator="smo", lost_lock="restart")).build(
        stress_1_scenarios(motor, np.arange(N, dtype=np.uint64))
    )
    lock = sims["control"]["lock"]
    lock["e_floor"][::4] *= 0.05
    lock["i_off"][1::4] *= 0.1
    lock["n_act"] = 5
    lock["action"][:8:4] = lib.LOCK_STOP
    lock["action"][4::8] = lib.LOCK_REPORT
    sims["err_limit"][2::8] *= 0.1
    sims["go_on"] = go_on
    return sims


def run_with_gains(plain: bool, periods: int) -> Array:
    """Decisions on k_s and on all gains, at random."""
    sims = nervous(True)
    gains = gain_records(sims, DEFAULT, 1e-3)
    obs, rng = np.zeros((N, SIGNAL_N), np.float32), np.random.default_rng(1)
    for _ in range(600):
        gains["wanted"] = rng.uniform(-1.0, 1.0, gains["wanted"].shape)
        k_s = rng.uniform(0.0, 1.0, N).astype(np.float32)
        sim_run(sims, periods, k_s, obs, gains, plain=plain, threads=1)
    return sims


@pytest.mark.parametrize("periods", [1, 3, 5])
def test_blocks_with_gains_equal_the_plain_loop(
    periods: int, state_bytes: Callable[[Array], bytes]
) -> None:
    sims, expected = (run_with_gains(plain, periods) for plain in (False, True))
    assert state_bytes(sims) == state_bytes(expected)
    assert len(np.unique(expected["control"]["hfi"]["u_inj"])) == N, "each has gains of its own"
    assert (expected["drive"]["x"]["lock"]["restarts"] > 0).any()
    assert (expected["lost"] == 0).sum() > 5


def test_a_block_that_ends_amid_a_decision_gets_each_gain_once() -> None:
    motor = Motor.load("paper")
    start = SimFactory(motor, DriveDesign()).build(
        stress_1_scenarios(motor, np.arange(16, dtype=np.uint64))
    )
    start["k_end"] = 12
    values = []
    for plain in (False, True):
        sims, obs = start.copy(), np.zeros((16, SIGNAL_N), np.float32)
        gains = gain_records(sims, DEFAULT, 1e-3)
        gains["wanted"] = -1.0
        for _ in range(4):
            sim_run(sims, 5, np.ones(16, np.float32), obs, gains, plain=plain, threads=1)
        assert (sims["k"] == 12).all()
        values.append(gains["value"])
    assert (values[0] == values[1]).all()


def run(go_on: bool, plain: bool) -> Array:
    sims = nervous(go_on)
    obs = np.zeros((N, SIGNAL_N), np.float32)
    for k_s in (0.9, 0.4, 0.1):
        sim_run(sims, PERIODS // 3, np.full(N, k_s, np.float32), obs, plain=plain, threads=1)
    return sims


def test_blocks_equal_the_plain_loop(state_bytes: Callable[[Array], bytes]) -> None:
    for go_on in (False, True):
        sims, expected = run(go_on, plain=False), run(go_on, plain=True)
        assert state_bytes(sims) == state_bytes(expected)
        lock, phase = expected["drive"]["x"]["lock"], expected["drive"]["x"]["start"]["phase"]
        assert (lock["alarms"] > 0).sum() > 3
        assert (lock["restarts"] > 0).any()
        assert (phase == lib.START_STOPPED).any()
        assert (lock["alarms"] == 0).sum() > 5


def test_a_lost_drive_goes_on_and_stays_lost() -> None:
    """Its sums and its verdict are those of a drive that stops there."""
    here, there = run(True, plain=False), run(False, plain=False)
    lost = there["lost"] != 0
    assert lost.any()
    assert not lost.all()
    assert (here["lost"] == there["lost"]).all()
    assert (here["k_lost"] == there["k_lost"]).all()
    assert (here["k_lost"][lost] == there["k"][lost]).all()
    assert (here["k"] == PERIODS).all()

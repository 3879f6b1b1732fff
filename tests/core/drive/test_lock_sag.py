"""A link that sags under load is no lost lock, and a drive lost meanwhile still says so."""

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.core.drive.test_lock_reaction import turn


@pytest.mark.parametrize(
    "motor", [Motor.load("paper"), Motor.load("ipmsm_2200w"), member(1000501, 8)], ids=str
)
def test_no_sag_is_an_alarm(motor: Motor) -> None:
    """Of 64, 3 of ``ipmsm_2200w`` and 22 of the random machine were while the current counted."""
    s = score(
        make_policy("eq25", motor), suite("sag", motor, 3, 64), SimFactory(motor, DriveDesign())
    )
    assert not s.lost.any()
    assert not s.lock["false_alarms"].any()


@pytest.mark.parametrize("motor", ["paper", "ipmsm_2200w"])
def test_a_drive_that_is_lost_in_a_sag_is_told(motor: str) -> None:
    """Turned by half a turn 5 ms after the link begins to fall, which lasts 10 ms."""
    machine = Motor.load(motor)
    sims = SimFactory(machine, DriveDesign()).build(suite("sag", machine, 3, 32))
    sims["go_on"] = 1
    k_s, obs = np.zeros(32, np.float32), np.zeros((32, SIGNAL_N), np.float32)
    sim_run(sims, round(0.605 / machine.T_s), k_s, obs)
    assert not (sims["drive"]["x"]["fault"] & lib.FAULT_LOCK).any()
    for j in range(32):
        turn(sims[j : j + 1], np.pi)
    sim_run(sims, round(0.05 / machine.T_s), k_s, obs)
    assert (sims["drive"]["x"]["fault"] & lib.FAULT_LOCK).all()

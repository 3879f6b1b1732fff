"""Whole drives on the inverter with a carrier."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.motor import Motor


def steady(motor: Motor, rpm: float, tau: float, *, carrier: bool, k_s: float) -> Array:
    """Sums of 0.2 s of a drive in steady state."""
    s = Scenarios.nominal(motor, np.array([3], dtype=np.uint64), 2.0)
    s.omega_0[:] = rpm * math.pi / 30.0
    s.omega[:] = s.omega_0[:, None]
    s.tau[:], s.tau_rate[:] = tau, 50.0
    sims = SimFactory(motor, DriveDesign(carrier=carrier)).build(s)
    weight, obs = np.full(1, k_s, np.float32), np.empty((1, SIGNAL_N), np.float32)
    sim_run(sims, 6000, weight, obs)
    sim_run(sims, 1000, weight, obs)
    assert sims["lost"][0] == 0
    return np.asarray(sims["sums"][0])


@pytest.mark.parametrize(("rpm", "k_s"), [(150.0, 1.0), (800.0, 0.0)])
def test_a_drive_runs_on_it_and_so_does_its_twin(motor: Motor, rpm: float, k_s: float) -> None:
    """Torque of drive and twin and the squared current are near those of the averaged inverter."""
    mean, switched = (steady(motor, rpm, 6.0, carrier=c, k_s=k_s) for c in (False, True))
    for name in ("tau", "tau_twin", "omega_m"):
        assert switched[name] / mean[name] == pytest.approx(1.0, abs=0.02)
    assert switched["i_sq_twin"] != mean["i_sq_twin"]
    assert abs(switched["err"] - mean["err"]) / 1000.0 < math.radians(2.0)


def test_blocks_of_drives_leave_it_to_the_plain_loop(
    motor: Motor, state_bytes: Callable[[Array], bytes]
) -> None:
    """Among 16 drives that would make a block, one with a carrier runs as it does alone."""
    scenarios = stress_1_scenarios(motor, np.arange(16, dtype=np.uint64))
    sims = SimFactory(motor, DriveDesign()).build(scenarios)
    sims["sensor"]["carrier"][5] = 1
    mixed, plain, alone = sims.copy(), sims.copy(), sims[5:6].copy()
    for drives, is_plain in ((mixed, False), (plain, True), (alone, True)):
        n = len(drives)
        obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
        sim_run(drives, 300, np.full(n, 0.5, np.float32), obs, plain=is_plain)
    assert state_bytes(mixed) == state_bytes(plain)
    assert state_bytes(mixed[5:6]) == state_bytes(alone)
    assert state_bytes(mixed[5:6]["drive"]) != state_bytes(mixed[4:5]["drive"])
    averaged_one = SimFactory(motor, DriveDesign()).build(scenarios[5:6])
    sim_run(averaged_one, 300, np.full(1, 0.5, np.float32), np.zeros((1, SIGNAL_N), np.float32))
    assert state_bytes(averaged_one["drive"]) != state_bytes(alone["drive"])

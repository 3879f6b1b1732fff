"""A drive that asks for all its current and stands: told, tried on the other pole, then stopped."""

import dataclasses

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor

SEVEN = [
    "paper",
    "ipmsm_2200w",
    "pmsyrm_5600w",
    "pmsrm_15kw",
    "brusa_hsm1",
    "ebike_hub",
    "formula_wheel",
]
SPEED = 0.3  # reference over rated


def started(motor: Motor, off: list[float], friction: float, inertia: float, action: str) -> Array:
    """Drives at rest, each estimate that far from its rotor [rad]; friction over rated torque."""
    s = Scenarios.nominal(motor, np.arange(len(off), dtype=np.uint64), 10.0)
    s.omega[:] = SPEED * motor.omega_rated / motor.n_p
    s.omega_0[:], s.theta_err_0[:] = 0.0, off
    s.omega_rate[:] = motor.omega_rated / motor.n_p
    s.tau[:], s.passive[:] = friction * motor.tau_rated, True
    s.J[:] = inertia
    sims = SimFactory(motor, DriveDesign(lost_lock=action)).build(s)
    sims["go_on"] = 1
    return sims


def run(sims: Array, motor: Motor, seconds: float) -> Array:
    """Run with the weight of injection alone; returns the fault bits of each drive."""
    k_s, obs = np.ones(len(sims), np.float32), np.zeros((len(sims), SIGNAL_N), np.float32)
    sim_run(sims, round(seconds / motor.T_s), k_s, obs)
    faults: Array = sims["drive"]["x"]["fault"]
    return faults


@pytest.mark.parametrize("name", ["pmsyrm_5600w", "pmsrm_15kw"])
def test_a_reluctance_machine_half_a_turn_off_under_friction_is_told(name: str) -> None:
    motor = Motor.load(name)
    sims = started(motor, [np.pi, np.pi - 0.2, np.pi + 0.2], 0.4, 1.0, "report")
    assert not run(sims, motor, 0.5).any()
    assert (run(sims, motor, 0.7) & lib.FAULT_LOCK).all()
    assert (sims["drive"]["x"]["lock"]["reason"] == lib.LOCK_STALL).all()


@pytest.mark.parametrize("name", SEVEN)
def test_a_restart_finds_the_other_pole(name: str) -> None:
    """Most run away and are told by another test; the pole may have to be found while they turn."""
    motor = Motor.load(name)
    sims = started(motor, [np.pi, np.pi - 0.2, np.pi + 0.2], 0.3, 1.0, "restart")
    faults = run(sims, motor, 2.0)
    wanted = SPEED * motor.omega_rated / motor.n_p
    assert (faults & lib.FAULT_LOCK).all()
    assert sims["drive"]["y"]["omega_m"] == pytest.approx(wanted, rel=0.1)


@pytest.mark.parametrize("name", SEVEN)
def test_a_blocked_shaft_is_told_and_stopped_in_the_end(name: str) -> None:
    motor = Motor.load(name)
    sims = started(motor, [0.0], 4.0, 1.0, "restart")
    assert not run(sims, motor, 0.45).any()
    assert run(sims, motor, 0.6) & lib.FAULT_LOCK
    assert run(sims, motor, 4.0) & lib.FAULT_STOPPED
    assert not np.any([sims["drive"]["u"][axis] for axis in ("a", "b")])


@pytest.mark.parametrize("name", SEVEN)
@pytest.mark.parametrize(("friction", "inertia"), [(0.3, 10.0), (0.95, 1.0)])
def test_a_start_that_is_hard_is_no_stall(name: str, friction: float, inertia: float) -> None:
    """Ten times the inertia, or nearly all of the torque: the shaft gets away in time."""
    motor = Motor.load(name)
    sims = started(motor, [0.0], friction, inertia, "report")
    assert not run(sims, motor, 1.5).any()


def test_restarts_of_a_stall_are_not_forgotten_meanwhile() -> None:
    """Of a machine whose shaft takes seconds to start, too."""
    paper = Motor.load("paper")
    for motor in [paper, dataclasses.replace(paper, J=100.0 * paper.J)]:
        lock = control_record(motor, DriveDesign())["lock"]
        assert lock["n_calm"] >= 2 * lock["n_stall"]

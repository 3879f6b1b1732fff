"""A drive that asks for all its current and stands: told, tried on the other pole, then stopped."""

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import DriveDesign
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
@pytest.mark.parametrize(("blocked", "restarts"), [(0.8, 1), (1.4, 2), (2.6, 4)])
def test_a_shaft_that_turned_before_it_was_blocked_keeps_its_pole(
    name: str, blocked: float, restarts: int
) -> None:
    """Also where nothing tells the pole at rest."""
    motor = Motor.load(name)
    sims = started(motor, [0.0], 0.1, 1.0, "restart")
    assert not run(sims, motor, 1.2).any()
    sims["profile"]["tau"][:] = 5.0 * motor.tau_rated
    assert run(sims, motor, blocked) & lib.FAULT_LOCK
    assert sims["drive"]["x"]["lock"]["restarts"] == restarts
    sims["profile"]["tau"][:] = 0.1 * motor.tau_rated
    y, x = sims["drive"]["y"], sims["drive"]["x"]
    slowest = 0.0
    for _ in range(100):
        run(sims, motor, 0.01)
        slowest = min(slowest, float(y["omega_m"][0]))
    wanted = SPEED * motor.omega_rated / motor.n_p
    assert y["omega_m"] == pytest.approx(wanted, rel=0.05)
    assert slowest > -0.1 * wanted
    assert abs(np.angle(np.exp(1j * (y["theta_e"] - x["est"]["theta"])))) < np.deg2rad(30.0)


@pytest.mark.parametrize("share", [0.002, 0.01])
def test_a_stall_is_told_and_ends_at_a_creeping_reference(share: float) -> None:
    """All current comes late, so tests pass for a second between restarts, which count on."""
    motor = Motor.load("ipmsm_2200w")
    sims = started(motor, [0.0], 4.0, 1.0, "restart")
    sims["profile"]["omega_ref"][:] = share * motor.omega_rated
    run(sims, motor, 0.1)
    sims["drive"]["x"]["control"]["i_int"] = 2.0 * motor.i_max
    assert run(sims, motor, 0.6) & lib.FAULT_LOCK
    sims["k_end"] = round(60.0 / motor.T_s)
    for _ in range(6):  # a new start every few seconds, with the integrator as it was
        faults = run(sims, motor, 8.0)
    assert faults & lib.FAULT_STOPPED


@pytest.mark.parametrize("name", SEVEN)
@pytest.mark.parametrize(("friction", "inertia"), [(0.3, 10.0), (0.95, 1.0)])
def test_a_start_that_is_hard_is_no_stall(name: str, friction: float, inertia: float) -> None:
    """Ten times the inertia, or nearly all of the torque: the shaft gets away in time."""
    motor = Motor.load(name)
    sims = started(motor, [0.0], friction, inertia, "report")
    assert not run(sims, motor, 1.5).any()

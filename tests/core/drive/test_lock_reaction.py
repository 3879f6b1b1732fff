"""What a drive does when the tests of core/drive/lock.h fail."""

from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")


def at_speed(share: float, load: float, motor: Motor = MOTOR, **settings: Any) -> Array:
    """One drive on the default estimator after 0.4 s at this speed and load."""
    s = Scenarios.nominal(motor, np.zeros(1, dtype=np.uint64), 10.0)
    s.omega[:] = share * motor.omega_rated / motor.n_p
    s.omega_0 = s.omega[:, 0].copy()
    s.tau[:] = load * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.2
    sims = SimFactory(motor, DriveDesign(**settings)).build(s)
    sims["go_on"] = 1
    run(sims, 0.4, share)
    return sims


def run(sims: Array, seconds: float, share: float) -> None:
    k_s = np.full(1, float(abs(share) < 0.2), np.float32)
    obs = np.zeros((1, SIGNAL_N), np.float32)
    sim_run(sims, round(seconds / MOTOR.T_s), k_s, obs)


def turn(sims: Array, angle: float) -> None:
    """Turn the estimate of the coupled observer."""
    x = sims["drive"]["x"]
    x["emf"]["pll"]["theta"] = np.angle(np.exp(1j * (x["emf"]["pll"]["theta"] + angle)))
    psi = (x["coupled"]["psi"]["a"] + 1j * x["coupled"]["psi"]["b"]) * np.exp(1j * angle)
    x["coupled"]["psi"]["a"], x["coupled"]["psi"]["b"] = psi.real, psi.imag


def err(sims: Array) -> float:
    x, y = sims["drive"]["x"], sims["drive"]["y"]
    return float(np.abs(np.angle(np.exp(1j * (y["theta_e"] - x["est"]["theta"]))))[0])


@pytest.mark.parametrize("share", [-1.0, 0.4, 1.0])
def test_a_drive_turned_by_half_a_turn_tells_and_comes_back(share: float) -> None:
    sims = at_speed(share, 0.3, lost_lock="restart")
    assert sims["drive"]["x"]["fault"][0] == 0
    turn(sims, np.pi)
    run(sims, 0.03, share)
    assert sims["drive"]["x"]["fault"][0] & lib.FAULT_LOCK
    run(sims, 0.4, share)
    assert sims["drive"]["x"]["start"]["phase"][0] == lib.START_DONE
    assert err(sims) < np.deg2rad(20.0)


def restart(sims: Array, share: float, most: float = 0.1) -> tuple[list[int], float]:
    """Phases until the drive is in control again, and the largest current meanwhile [A]."""
    phases: list[int] = []
    x, largest = sims["drive"]["x"], 0.0
    sims["control"]["lock"]["action"] = lib.LOCK_RESTART
    x["lock"]["bad"], x["lock"]["calm"] = sims["control"]["lock"]["n_act"], 0
    sims["control"]["lock"]["i_off"] = -1.0
    for _ in range(round(most / MOTOR.T_s)):
        run(sims, MOTOR.T_s, share)
        phase = int(x["start"]["phase"][0])
        phases += [phase] if phases[-1:] != [phase] else []
        if phase != lib.START_DONE:
            sims["control"]["lock"]["i_off"] = 1e9
            if phase != lib.START_QUIET:
                y = sims["drive"]["y"]
                largest = max(largest, float(np.hypot(y["i_d"], y["i_q"])[0]))
        elif largest > 0.0:
            break
    return phases, largest


@pytest.mark.parametrize(("share", "load"), [(0.0, 0.0), (0.05, 1.0), (0.5, -1.0), (1.0, 1.0)])
def test_a_healthy_drive_is_silent(share: float, load: float) -> None:
    sims = at_speed(share, load, lost_lock="restart")
    run(sims, 0.3, share)
    lock = sims["drive"]["x"]["lock"][0]
    assert (lock["alarms"], lock["bad"], lock["reason"]) == (0, 0, 0)


@pytest.mark.parametrize("share", [-1.3, -0.9, 0.9, 1.3])
def test_a_shaft_is_caught_in_its_own_direction_at_any_speed(share: float) -> None:
    """Its EMF turns by up to 280 degrees while it is watched."""
    motor = Motor.load("brusa_hsm1")
    sims = at_speed(share, 0.0, motor)
    phases, largest = restart(sims, share)
    assert lib.START_FLY in phases and phases[-1] == lib.START_DONE
    assert err(sims) < np.deg2rad(20.0)
    assert largest < 0.5 * motor.i_rated


@pytest.mark.parametrize("estimator", ["smo", "flux", "errors"])
@pytest.mark.parametrize("share", [-0.9, 0.5])
def test_another_observer_goes_on_as_the_coupled_one(share: float, estimator: str) -> None:
    """After a restart two drives on the same shaft give the same voltages."""
    here = at_speed(share, 0.5, estimator=estimator)
    here["control"]["L_q"]["y"] = control_record(MOTOR, DriveDesign())["L_q"]["y"]
    restart(here, share)
    there = here.copy()
    there["control"]["estimator"] = lib.ESTIMATE_COUPLED
    for sims in (here, there):
        run(sims, 0.05, share)
        assert err(sims) < np.deg2rad(10.0)
    assert here["drive"].tobytes() == there["drive"].tobytes()


@pytest.mark.parametrize("share", [0.03, 0.5])
def test_nothing_is_injected_while_the_emf_is_watched(share: float) -> None:
    """However much the drive injected before, and along whatever axis."""
    sims = at_speed(share, 0.0)
    sims["control"]["lock"]["action"] = lib.LOCK_RESTART
    x = sims["drive"]["x"]
    x["lock"]["bad"], x["lock"]["calm"] = sims["control"]["lock"]["n_act"], 0
    x["hfi"]["hold"], x["hfi"]["sign_1"] = sims["control"]["hfi"]["n_hold"], 1.0
    sims["control"]["lock"]["i_off"] = -1.0
    seen = []
    for _ in range(round(0.05 / MOTOR.T_s)):
        run(sims, MOTOR.T_s, share)
        if x["start"]["phase"][0] in (lib.START_QUIET, lib.START_CATCH, lib.START_FLY):
            seen.append([float(x["hfi"][name][0]) for name in ("hold", "sign_1", "sign_2")])
        elif seen:
            break
    assert len(seen) > 20 and not np.any(seen)


def test_the_load_of_before_is_not_forgotten() -> None:
    """A drive at rest takes control with the torque that held it, from zero with its slope."""
    sims = at_speed(0.0, 0.6)
    wanted = float(sims["drive"]["x"]["control"]["i_ref"]["q"][0])
    before = float(sims["drive"]["x"]["control"]["i_int"][0])
    restart(sims, 0.0)
    control, x = sims["control"]["control"], sims["drive"]["x"]
    assert x["control"]["i_int"][0] == pytest.approx(before, abs=0.1 * abs(before))
    assert abs(x["control"]["i_ref"]["q"][0]) < 10.0 * control["i_q_step"][0] < 0.5 * wanted


@pytest.mark.parametrize("share", [-0.15, 0.15])
@pytest.mark.parametrize("half", [False, True])
def test_the_emf_tells_the_pole_without_pulses(share: float, half: bool) -> None:
    sims = at_speed(share, 0.0)
    if half:
        turn(sims, np.pi)
    phases, _ = restart(sims, share)
    assert lib.START_LOCK in phases and lib.START_POLE not in phases
    run(sims, 5e-3, share)
    assert err(sims) < np.deg2rad(15.0)
    assert sims["drive"]["x"]["fault"][0] & lib.FAULT_POLE == 0


@pytest.mark.parametrize("half", [False, True])
def test_a_machine_whose_pulses_tell_nothing_takes_the_other_pole(half: bool) -> None:
    """At rest, where no EMF tells it either: a drive that had to act was far from its rotor."""
    sims = at_speed(0.0, 0.0, Motor.load("brusa_hsm1"))
    if half:
        turn(sims, np.pi)
    phases, _ = restart(sims, 0.0)
    assert lib.START_LOCK in phases and lib.START_POLE not in phases
    assert (err(sims) < np.deg2rad(20.0)) == half
    assert sims["drive"]["x"]["fault"][0] & lib.FAULT_POLE


@pytest.mark.parametrize("estimator", ["smo", "flux", "errors"])
@pytest.mark.parametrize("share", [-0.9, 0.0, 0.5])
def test_the_coupled_observer_takes_over_before_a_restart(share: float, estimator: str) -> None:
    """At the alarm, with angle and torque as they are; tests that then pass leave it at that."""
    sims = at_speed(share, 0.6, estimator=estimator, lost_lock="restart")
    x, y, lock = sims["drive"]["x"], sims["drive"]["y"], sims["control"]["lock"]
    torque, limit = float(y["tau"][0]), float(lock["i_off"][0])
    lock["i_off"] = -1.0
    for _ in range(60):
        run(sims, MOTOR.T_s, share)
        if x["start"]["again"][0]:
            lock["i_off"] = limit
        assert x["start"]["phase"][0] == lib.START_DONE
        assert y["tau"][0] == pytest.approx(torque, abs=0.35 * MOTOR.tau_rated)
        assert err(sims) < np.deg2rad(15.0)
    assert x["start"]["again"][0] == 1 and x["lock"]["restarts"][0] == 0
    assert x["fault"][0] == lib.FAULT_LOCK


def test_after_the_change_a_machine_without_pulses_takes_the_nearer_pole() -> None:
    """At rest injection has drawn the estimate to it; nothing else tells the pole."""
    sims = at_speed(0.0, 0.0, Motor.load("brusa_hsm1"), estimator="smo")
    phases, _ = restart(sims, 0.0)
    assert lib.START_LOCK in phases and lib.START_POLE not in phases
    assert err(sims) < np.deg2rad(20.0)


def test_restarts_are_bounded_and_then_there_is_no_voltage() -> None:
    sims = at_speed(0.5, 0.3, lost_lock="restart")
    sims["control"]["lock"]["i_off"] = -1.0  # never satisfied
    seen = set()
    for _ in range(400):
        run(sims, 2e-3, 0.5)
        seen.add(int(sims["drive"]["x"]["lock"]["restarts"][0]))
    x = sims["drive"]["x"][0]
    assert seen == set(range(int(control_record(MOTOR, DriveDesign())["lock"]["restarts"]) + 1))
    assert x["start"]["phase"] == lib.START_STOPPED
    assert x["fault"] & lib.FAULT_STOPPED
    assert (sims["drive"]["u"]["a"][0], sims["drive"]["u"]["b"][0]) == (0.0, 0.0)


def test_report_changes_nothing_else() -> None:
    """A drive whose tests fail runs as one whose tests pass, to the bit."""
    here, there = (at_speed(0.5, 0.3, lost_lock="report") for _ in range(2))
    here["control"]["lock"]["i_off"] = -1.0
    run(here, 0.2, 0.5)
    run(there, 0.2, 0.5)
    assert here["drive"]["x"]["fault"][0] == lib.FAULT_LOCK
    assert here["drive"]["y"].tobytes() == there["drive"]["y"].tobytes()


def test_the_period_that_says_stopped_applies_no_voltage() -> None:
    sims = at_speed(0.5, 0.3, lost_lock="stop")
    sims["control"]["lock"]["i_off"] = -1.0
    before = []
    for _ in range(round(0.2 / MOTOR.T_s)):
        run(sims, MOTOR.T_s, 0.5)
        u = abs(complex(sims["drive"]["u"]["a"][0], sims["drive"]["u"]["b"][0]))
        if sims["drive"]["x"]["fault"][0] & lib.FAULT_STOPPED:
            break
        before.append(u)
    assert min(before) > 50.0 and u == 0.0


def test_stop_is_for_good() -> None:
    sims = at_speed(0.5, 0.3, lost_lock="stop")
    sims["control"]["lock"]["i_off"] = -1.0
    run(sims, 0.2, 0.5)
    assert sims["drive"]["x"]["start"]["phase"][0] == lib.START_STOPPED

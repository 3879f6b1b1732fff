"""Damage to any word of the drive's state: it heals or is flagged, and no voltage shows it."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import CONTROL, Array, lib, pointer, struct_dtype
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from sensorless.observers.lock_design import ACTIONS
from tests.helpers.lock import unwatched

STATE, INPUT = struct_dtype("drive_state_t"), struct_dtype("drive_in_t")
BAD = (math.nan, math.inf, -math.inf, 1e30, -1e30)


def floats(dtype: np.dtype[Any], path: str = "", at: int = 0) -> Iterator[tuple[str, int]]:
    """Name and word of every float of a struct."""
    for name in dtype.names or ():
        field, offset = dict(dtype.fields or {})[name][:2]
        if field.names:
            yield from floats(field, f"{path}{name}.", at + offset)
        elif field.kind == "f":
            yield path + name, (at + offset) // 4


FLOATS = dict(floats(STATE))


class Drive:
    """A drive on a turning current, as after a start or while it seeks its rotor."""

    def __init__(
        self, motor: Motor, estimator: str, seek: bool, moment: int, weight: float = 0.0
    ) -> None:
        self.params = np.zeros(1, dtype=CONTROL)
        design = DriveDesign(estimator=estimator, speed_weight=weight)
        self.params[0] = control_record(motor, design)
        unwatched(self.params)
        self.x, self.signal = np.zeros(1, dtype=STATE), np.zeros(1, dtype=INPUT)
        self.pointers = (
            pointer(self.params, "drive_params_t[]"),
            pointer(self.x, "drive_state_t[]"),
            pointer(self.signal, "drive_in_t[]"),
        )
        lib.drive_init(*self.pointers[:2], 0.3, 80.0, 0.5)
        if seek:
            lib.drive_find_rotor(self.pointers[1])
        self.signal["u_dc"], self.signal["omega_ref"], self.signal["k_s_ref"] = 540.0, 80.0, 0.5
        self.k, self.words = 0, self.x.view(np.float32)
        for _ in range(moment):
            self.step()
        self.kept = self.words.copy(), moment

    def back(self) -> None:
        self.words[:], self.k = self.kept

    def step(self) -> float:
        """Largest component of the voltage [V]."""
        self.signal["i_a"] = math.cos(0.016 * self.k)
        self.signal["i_b"] = math.cos(0.016 * self.k - 2.1)
        self.k += 1
        u = lib.drive_step(*self.pointers)
        return float(u.a if not abs(u.a) < abs(u.b) else u.b)

    def sound(self) -> bool:
        return bool((np.abs(self.words) < 1e15).all())

    def flagged(self) -> bool:
        return bool(self.x["fault"][0] & lib.FAULT_STATE)


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(("seek", "moment"), [(False, 3), (False, 400), (True, 12), (True, 60)])
def test_every_word_heals_or_is_flagged(
    motor: Motor, estimator: str, seek: bool, moment: int
) -> None:
    drive = Drive(motor, estimator, seek, moment)
    limit = float(drive.params["guard"]["u_out"][0])
    for name, word in FLOATS.items():
        for value in BAD:
            drive.back()
            drive.words[word] = value
            assert abs(drive.step()) <= limit, (name, value)
            assert drive.sound(), (name, value)


@pytest.mark.parametrize("seek", [False, True])
def test_what_a_low_pass_would_hide_is_flagged_at_once(motor: Motor, seek: bool) -> None:
    """A word that its low-pass follows slowly holds a huge number for long, and no sum shows it."""
    drive = Drive(motor, "coupled", seek, 12)
    for name in ("control.i.q", "theta_hfi", "theta_smo", "signal.omega"):
        drive.back()
        drive.words[FLOATS[name]] = 1e16
        drive.step()
        assert drive.sound(), name


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_damaged_spacing_of_the_curves_reads_no_other_word(motor: Motor, estimator: str) -> None:
    """With a sign that is wrong it is as without: the left node is never below the first."""
    right, wrong = (Drive(motor, estimator, False, 0) for _ in range(2))
    wrong.params["control"]["curve_inv_step"] *= -1.0
    for _ in range(200):
        assert right.step() == wrong.step()


@pytest.mark.parametrize("seed", range(3))
def test_a_state_of_arbitrary_bits_gives_no_voltage_beyond_the_limit(
    motor: Motor, seed: int
) -> None:
    """Also phases and counters: the drive comes back to a state that is sound."""
    rng = np.random.default_rng(seed)
    drive = Drive(motor, list(ESTIMATORS)[seed + 2], False, 1)
    limit = float(drive.params["guard"]["u_out"][0])
    for trial in range(60):
        bits = drive.words.view(np.uint32)
        hit = np.flatnonzero(rng.random(bits.shape) < (0.02, 0.3, 1.0)[trial % 3])
        bits[hit] = rng.integers(0, 2**32, len(hit), dtype=np.uint64).astype(np.uint32)
        drive.x["fault"] = 0
        for k in range(48):
            assert abs(drive.step()) <= limit
            assert drive.sound() or k < drive.params["lock"]["n"][0]
        assert 0 <= drive.x["start"]["phase"][0] <= lib.START_STOPPED


@pytest.mark.parametrize(
    "before", ["DONE", "CATCH", "FLY", "SCAN", "LOCK", "POLE", "SETTLE", "QUIET"]
)
@pytest.mark.parametrize("bit", range(32))
def test_a_flipped_bit_of_the_phase_is_flagged_at_once(motor: Motor, before: str, bit: int) -> None:
    """No phase is one bit from another: a drive in control does not seek its rotor unasked."""
    drive = Drive(motor, "coupled", before != "DONE", 40)
    drive.x["start"]["phase"] = np.uint32(getattr(lib, f"START_{before}") ^ 1 << bit).astype(
        np.int32
    )
    assert drive.step() == 0.0 and drive.flagged()


@pytest.mark.parametrize("word", ["d", "q"])
@pytest.mark.parametrize("value", [1.01e15, -1e16, 1e20])
def test_a_damaged_integrator_of_the_current_control_is_flagged_at_once(
    motor: Motor, word: str, value: float
) -> None:
    drive = Drive(motor, "coupled", False, 100)
    drive.x["control"]["u_int"][word] = value
    assert drive.step() == 0.0 and drive.flagged()


@pytest.mark.parametrize("value", BAD)
def test_a_stopped_drive_holds_no_damage(motor: Motor, value: float) -> None:
    drive = Drive(motor, "coupled", False, 100)
    lib.drive_trip(drive.pointers[1])
    drive.step()
    drive.kept = drive.words.copy(), drive.k
    for name, word in FLOATS.items():
        drive.back()
        drive.words[word] = value
        for _ in range(3):
            assert drive.step() == 0.0, name
        assert drive.sound(), name
        assert drive.x["start"]["phase"][0] == lib.START_STOPPED


def test_a_damaged_drive_seeks_its_rotor_and_keeps_its_faults(motor: Motor) -> None:
    drive = Drive(motor, "coupled", False, 100)
    drive.x["fault"] = lib.FAULT_U_DC
    drive.x["control"]["i_int"] = math.nan
    assert drive.step() == 0.0
    assert drive.x["fault"][0] == lib.FAULT_U_DC | lib.FAULT_STATE
    assert drive.x["start"]["phase"][0] == lib.START_CATCH


@pytest.mark.parametrize("action", ["report", "restart", "stop"])
@pytest.mark.parametrize("before", [False, True])
def test_a_damaged_drive_that_stops_or_has_stopped_gives_no_voltage_any_more(
    motor: Motor, action: str, before: bool
) -> None:
    drive = Drive(motor, "coupled", False, 100)
    drive.params["lock"]["action"] = ACTIONS[action]
    if before:
        drive.x["fault"] |= lib.FAULT_STOPPED
        drive.x["start"]["phase"] = lib.START_STOPPED
        drive.step()
    drive.x["control"]["i_int"] = math.nan
    latched = before or action == "stop"
    end = [abs(drive.step()) for _ in range(200)]
    assert bool(drive.x["fault"][0] & lib.FAULT_STOPPED) == latched
    assert (max(end) == 0.0) == latched
    assert drive.sound() and drive.flagged()


def test_memory_that_was_never_begun_is_flagged_within_a_test_of_the_lock(motor: Motor) -> None:
    """All other words may be such as a drive leaves them."""
    for begun in (0, -1, lib.DRIVE_BEGUN ^ 1, lib.DRIVE_BEGUN):
        drive = Drive(motor, "coupled", False, 30)
        drive.x["begun"] = begun
        for _ in range(int(drive.params["lock"]["n"][0])):
            drive.step()
        assert drive.flagged() == (begun != lib.DRIVE_BEGUN)
        assert drive.x["begun"][0] == lib.DRIVE_BEGUN


def test_a_healthy_drive_is_not_flagged_at_its_largest_voltage(motor: Motor) -> None:
    """Voltage limit, injection and dead-time compensation at once, at the highest link."""
    drive = Drive(motor, "coupled", False, 1)
    drive.signal["u_dc"], drive.signal["omega_ref"] = 1.49 * motor.u_dc, 750.0
    largest: Array = np.array([abs(drive.step()) for _ in range(3000)])
    assert 0.5 * motor.u_dc < largest.max() < drive.params["guard"]["u_out"][0]
    # Without a machine the estimate comes to its bound.
    assert drive.x["fault"][0] & ~lib.FAULT_LOCK == 0


def test_a_damaged_counter_does_not_put_the_watch_to_sleep() -> None:
    """``lock.wait`` is a whole number, which the check of floats cannot judge."""
    drive = Drive(Motor.load("paper"), "coupled", False, 0)
    for wait in (10**9, -(10**9)):
        drive.x["lock"]["wait"] = wait
        drive.step()
        assert 0 <= drive.x["lock"]["wait"][0] <= drive.params["lock"]["n"][0]


IMPOSSIBLE = {
    "hfi.pll.theta": 1e5,
    "emf.pll.theta": -40.0,
    "k_s": -1e3,
    "coupled.drift.trust": 1e5,
    "coupled.drift.sign": -5.0,
}


@pytest.mark.parametrize("estimator", ["coupled", "flux", "smo"])
@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_is_finite_but_impossible_is_flagged_within_a_test_of_the_lock(
    motor: Motor, estimator: str, name: str
) -> None:
    """Unless it heals: the coupled observer makes the injection's angle anew in every period."""
    drive = Drive(motor, estimator, False, 400)
    drive.words[FLOATS[name]] = IMPOSSIBLE[name]
    for _ in range(int(drive.params["lock"]["n"][0])):
        drive.step()
    heals = estimator == "coupled" and name == "hfi.pll.theta"
    assert drive.flagged() != heals
    assert abs(drive.words[FLOATS[name]]) <= math.pi


@pytest.mark.parametrize("machine", ["paper", "brusa_hsm1", "ebike_hub"])
@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_the_speed_integrator_is_flagged_beyond_what_speed_control_can_make_it(
    machine: str, weight: float
) -> None:
    """Its bound: the current limit, and what the reference leaves to it at the highest speed.

    The limit as it counts at the most d current, where reluctance makes much of the torque.
    """
    motor = Motor.load(machine)
    for share, flagged in ((1.0, False), (-1.0, False), (1.5, True), (-1.5, True)):
        drive = Drive(motor, "coupled", False, 4, weight)
        p = drive.params["control"]
        omega = drive.params["coupled"]["omega_max"][0]
        assert omega >= drive.params["guard"]["omega"][0]
        aux = p["psi_f"][0] + (p["L_d"][0] - p["L_q"][0]) * p["i_d_min"][0]
        most = p["i_max"][0] * aux / p["psi_f"][0]
        most += p["k_p_speed"][0] * (1.0 - weight) * omega
        n = int(drive.params["lock"]["n"][0])
        for _ in range(n):
            drive.x["control"]["i_int"] = share * most
            drive.step()
        assert drive.flagged() == flagged, share


@pytest.mark.parametrize("name", ["u_1.a", "u_1.b", "u_2.a", "u_2.b", "smo.i_hat.b", "smo.z.a"])
def test_a_seeking_drive_flags_at_once_what_its_observer_would_hide(
    motor: Motor, name: str
) -> None:
    for value in BAD[:3]:
        drive = Drive(motor, "coupled", True, 12)
        assert drive.x["start"]["phase"][0] == lib.START_CATCH
        drive.words[FLOATS[name]] = value
        assert drive.step() == 0.0 and drive.flagged()


@pytest.mark.parametrize("moment", [3, 12, 60])
@pytest.mark.parametrize("weight", [1e10, 1.001, -1e-3, math.nan])
def test_a_seeking_drive_flags_a_damaged_weight_at_once(
    motor: Motor, moment: int, weight: float
) -> None:
    """It takes control with it."""
    drive = Drive(motor, "coupled", True, moment)
    assert drive.x["start"]["phase"][0] != lib.START_DONE
    drive.words[FLOATS["k_s"]] = weight
    assert drive.step() == 0.0 and drive.flagged()
    assert drive.words[FLOATS["k_s"]] == 1.0

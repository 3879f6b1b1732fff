"""What drive_init makes of its arguments, and what a trip of the hardware stops."""

import math

import numpy as np
import pytest

from sensorless.core.api import lib, pointer
from sensorless.machine.motor import Motor
from tests.helpers.controller import Drive

OVER, COMMAND = lib.FAULT_OVER_CURRENT, lib.FAULT_COMMAND
STOP = OVER | lib.FAULT_STOPPED


def test_a_trip_of_the_hardware_is_a_stop(motor: Motor) -> None:
    """No voltage from then on, whatever the samples say; drive_init starts anew."""
    drive = Drive(motor)
    assert drive.step() != (0.0, 0.0)
    lib.drive_trip(pointer(drive.x, "drive_state_t[]"))
    for i in (0.5, -0.5, 9.0):
        assert drive.step(i_a=i) == (0.0, 0.0)
        assert drive.x["fault"][0] & (OVER | lib.FAULT_STOPPED) == OVER | lib.FAULT_STOPPED


@pytest.mark.parametrize(("word", "value"), [("fault", STOP), ("begun", lib.DRIVE_TRIPPED)])
@pytest.mark.parametrize("phase", ["START_SCAN", "START_FLY", "START_DONE"])
def test_a_trip_that_a_period_wrote_over_is_a_stop_within_a_millisecond(
    motor: Motor, phase: str, word: str, value: int
) -> None:
    """An interrupt that calls drive_trip within drive_step: one of its words may be all left."""
    drive = Drive(motor)
    drive.step()
    drive.x[word] = value
    drive.x["start"]["phase"] = getattr(lib, phase)
    for _ in range(round(1e-3 / motor.T_s) + 2):
        last = drive.step()
    assert last == (0.0, 0.0) and drive.x["start"]["phase"][0] == lib.START_STOPPED
    assert drive.x["fault"][0] & STOP == STOP
    lib.drive_find_rotor(pointer(drive.x, "drive_state_t[]"))
    assert drive.x["start"]["phase"][0] == lib.START_STOPPED


def test_no_period_writes_the_word_that_tells_a_trip(motor: Motor) -> None:
    """Also none that damage makes a new start; drive_init alone ends a trip."""
    drive = Drive(motor)
    lib.drive_trip(pointer(drive.x, "drive_state_t[]"))
    for damage in (0.0, math.nan):
        drive.x["u_1"]["a"] = damage
        drive.x["fault"] = 0
        assert drive.step() == (0.0, 0.0)
        assert drive.x["begun"][0] == lib.DRIVE_TRIPPED
        assert drive.x["fault"][0] & STOP == STOP
    drive = Drive(motor)
    assert drive.x["begun"][0] == lib.DRIVE_BEGUN and drive.step() != (0.0, 0.0)


@pytest.mark.parametrize(
    ("argument", "value", "becomes"),
    [
        ("theta", math.nan, 0.0),
        ("theta", math.inf, 0.0),
        ("theta", -math.inf, 0.0),
        ("theta", 3e38, 0.0),
        ("theta", -1.1e4, 0.0),
        ("omega", math.nan, 0.0),
        ("omega", math.inf, 0.0),
        ("omega", -math.inf, 0.0),
        ("omega", 3e38, 753.016),
        ("omega", -800.0, -753.016),
        ("k_s", math.nan, 1.0),
        ("k_s", math.inf, 1.0),
        ("k_s", -math.inf, 0.0),
        ("k_s", 1.001, 1.0),
        ("k_s", -1e-30, 0.0),
    ],
)
def test_drive_init_mends_its_arguments(
    motor: Motor, argument: str, value: float, becomes: float
) -> None:
    """Each bad argument becomes a good one, sets its bit, and no voltage is out of bounds."""
    start = {"theta": 0.3, "omega": 50.0, "k_s": 1.0, argument: value}
    drive = Drive(motor, start["omega"], theta=start["theta"], k_s=start["k_s"])
    found = {"theta": drive.x["est"]["theta"], "omega": drive.x["est"]["omega"]}
    found["k_s"] = drive.x["k_s"]
    assert found[argument][0] == pytest.approx(becomes, rel=1e-5)
    assert drive.x["fault"][0] == COMMAND
    assert np.all(np.isfinite(drive.numbers()))
    for _ in range(100):
        assert math.hypot(*drive.step()) < motor.u_dc
    assert drive.x["fault"][0] == COMMAND


@pytest.mark.parametrize("turns", [-1000, -3, -2, -1, 0, 1, 2, 3, 1000])
def test_drive_init_takes_any_number_of_turns(motor: Motor, turns: int) -> None:
    for at in (-3.1, -0.3, 0.0, 2.9):
        drive = Drive(motor, theta=at + 2.0 * math.pi * turns)
        assert drive.x["est"]["theta"][0] == pytest.approx(at, abs=1e-3)
        assert drive.x["fault"][0] == 0

"""Mistakes of an installation phase by phase, and what is said of a check's result."""

import numpy as np
import pytest

from sensorless.core.api import TRACE_NAMES, Array
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.identify.bring_up import survey as survey_module
from sensorless.identify.bring_up.check import Found, check, drives_at_rest
from sensorless.identify.bring_up.mistakes import MISTAKES
from sensorless.identify.bring_up.survey import count_pole_pairs, survey, turning_drive
from sensorless.identify.bring_up.words import verdict
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.units import wrapped

PAPER = Motor.load("paper")
ABC = np.array([1.0, 0.5, -1.5])
"""Of three phases."""


def plane(a: float, b: float, c: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Vector of three phases; what they have in common is not in it."""
    return np.array([(2.0 * a - b - c) / 3.0, (b - c) / np.sqrt(3.0)])


@pytest.mark.parametrize(
    ("name", "a", "b", "c"),
    [
        ("current-sign", -1.0, -0.5, 1.5),
        ("current-bc-swapped", 1.0, -1.5, 0.5),
        ("current-ab-swapped", 0.5, 1.0, -1.5),
        ("current-ca-swapped", -1.5, 0.5, 1.0),
        ("current-phases-shifted", 0.5, -1.5, 1.0),  # each channel shows the next phase
        ("channel-a-sign", -1.0, 0.5, 0.5),  # the third is less the sum of both
        ("channel-b-sign", 1.0, -0.5, -0.5),
        ("channel-a-gain-0.5", 0.5, 0.5, -1.0),
        ("channel-b-gain-1.5", 1.0, 0.75, -1.75),
    ],
)
def test_what_the_samples_become(name: str, a: float, b: float, c: float) -> None:
    mistake = MISTAKES[name]
    assert np.reshape(mistake.current, (2, 2)) @ plane(*ABC) == pytest.approx(plane(a, b, c))
    assert mistake.voltage == (1.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("name", "a", "b", "c"),
    [
        ("voltage-sign", -1.0, -0.5, 1.5),
        ("voltage-bc-swapped", 1.0, -1.5, 0.5),
        ("voltage-ab-swapped", 0.5, 1.0, -1.5),
        ("voltage-ca-swapped", -1.5, 0.5, 1.0),
        ("voltage-phases-shifted", -1.5, 1.0, 0.5),
        ("duty-a-stuck", 0.0, 0.5, -1.5),
        ("duty-b-stuck", 1.0, 0.0, -1.5),
        ("duty-c-stuck", 1.0, 0.5, 0.0),
        ("duty-half", 0.5, 0.25, -0.75),
        ("duty-double", 2.0, 1.0, -3.0),
        ("duty-two-thirds", 2 / 3, 1 / 3, -1.0),
        ("duty-three-halves", 1.5, 0.75, -2.25),
        ("duty-root-3", 3**0.5, 0.5 * 3**0.5, -1.5 * 3**0.5),
        ("duty-line", 3**-0.5, 0.5 * 3**-0.5, -1.5 * 3**-0.5),
    ],
)
def test_what_the_voltages_become(name: str, a: float, b: float, c: float) -> None:
    mistake = MISTAKES[name]
    assert np.reshape(mistake.voltage, (2, 2)) @ plane(*ABC) == pytest.approx(plane(a, b, c))
    assert mistake.current == (1.0, 0.0, 0.0, 1.0)


def test_a_record_has_it_all() -> None:
    """The driver's compensation is full from 2 A on."""
    record = MISTAKES["compensated-0.9"].record(2.0)[0]
    assert (record["delay"], record["added"]) == pytest.approx((1.0, 0.9))
    assert record["inv_i_add"] == 0.5
    assert MISTAKES["delay-1.5"].record(2.0)[0]["delay"] == 1.5


def test_drives_at_rest_have_the_errors_of_the_suite_and_the_least_link(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    built: list[Scenarios] = []
    monkeypatch.setattr(SimFactory, "build", lambda _, s, **__: built.append(s))
    seeds = np.arange(20, dtype=np.uint64)
    drives_at_rest(PAPER, seeds)
    (s,), drawn = built, stress_scenarios(PAPER, seeds)
    assert not s.omega.any() and not s.omega_0.any() and not s.tau.any()
    assert np.ptp(drawn.u_dc, axis=1).max() > 0.0
    assert (s.u_dc == drawn.u_dc.min(axis=1, keepdims=True)).all()
    for name in ("gain", "offset", "theta_0", "dead_time"):
        assert np.array_equal(getattr(s, name), getattr(drawn, name))


def test_a_check_leaves_its_drive_as_it_is() -> None:
    drive = drives_at_rest(PAPER, np.array([3], dtype=np.uint64))
    before = drive.copy()
    first = check(PAPER, drive)[0]
    assert drive.tobytes() == before.tobytes() and check(PAPER, drive)[0] == first


def test_pole_pairs_are_counted_at_three_tenths_of_rated_speed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    built: list[Scenarios] = []
    monkeypatch.setattr(SimFactory, "build", lambda _, s, **__: built.append(s))
    turning_drive(PAPER, 7)
    (s,) = built
    speed = 0.3 * 1500.0 * np.pi / 30.0
    assert s.omega_0 == pytest.approx(speed) and np.ravel(s.omega) == pytest.approx(speed)
    assert not s.tau.any() and s.duration == 20.0


def test_the_turns_of_the_estimate_are_counted_over_one_of_the_shaft(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The rotor turns three times and the estimate twice while the shaft does once.

    At 50 rad/s, 100 periods of 0.2 ms are a radian of the shaft, so it takes seven times as many.
    """
    asked: list[float] = []

    def traced(drive: object, n: int, k_s: float) -> Array:
        time: Floats = np.asarray((n * len(asked) + 1.0 + np.arange(n)) * PAPER.T_s)
        asked.append(k_s)
        rows = np.zeros((n, len(TRACE_NAMES)))
        rows[:, TRACE_NAMES.index("omega_m")] = 50.0
        rows[:, TRACE_NAMES.index("theta_e")] = wrapped(3.0 * 50.0 * time)
        rows[:, TRACE_NAMES.index("theta_e_err")] = wrapped((3.0 - 2.0) * 50.0 * time)
        return rows

    drive = turning_drive(PAPER, 7)
    drive["drive"]["x"]["est"]["theta"] = 0.0
    monkeypatch.setattr(survey_module, "sim_trace", traced)
    assert count_pole_pairs(drive) == 2 and len(asked) == 7


def test_what_is_counted_of_many_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    """One is not flagged, one by a bit that does not name the mistake, one by one that does."""
    said = [(), ("current",), ("delay", "current")]
    drives = np.arange(3)
    monkeypatch.setattr(survey_module, "drives_at_rest", lambda *_: drives)
    found = [Found(x, "right", 1.0, 0.0, 1.0, 0.0) for x in said]
    monkeypatch.setattr(survey_module, "check", lambda _, d, __: (found[int(d[0])], None))
    counted = dict(survey(PAPER, np.arange(3)))
    assert set(counted) == {"right", *MISTAKES}
    late = counted["delay-2"]
    assert (late.drives, late.flagged, late.named) == (3, 2, 1)
    assert counted["right"].named == 0


@pytest.mark.parametrize("lost", [-10.5, -9.5, 0.0, 0.5, 1.0, 9.5, 10.5, float("nan")])
def test_which_lost_voltage_is_one(lost: float) -> None:
    told = " ".join(verdict(Found((), "right", 1.0, 0.97, lost, 2.5)))
    assert "voltage 97 % of the commanded one" in told
    assert ("is --motor the file" in told) == (not abs(lost) < 10.0)
    assert ("the motor file's: not judged" in told) == (lost == 1.0)
    for share, words in ((0.5, "motor file's: 50 %"), (-9.5, "-950 %"), (0.0, "file's: 0 %")):
        assert (words in told) == (lost == share)
    assert ("resistance 2.5 ohm" in told) == (abs(lost) < 10.0)


@pytest.mark.parametrize("fault", ["current", "moves", "deaf"])
def test_a_check_that_ended_early_has_no_delay(fault: str) -> None:
    (line,) = verdict(Found((fault,), "right", 0.0, 0.0, 1.0, 0.0))
    assert line.startswith(f"{fault}: ")
    assert "delay 1.25 periods" in verdict(Found(("delay",), "right", 1.25, 0.0, 1.0, 0.0))[0]

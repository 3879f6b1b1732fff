"""A scenario from words of the command line: one of a suite, or plans of speed and load."""

import re
from pathlib import Path

import numpy as np

from sensorless.core.api import PROFILE_N
from sensorless.envs.counter_random import check_seed, combine
from sensorless.envs.scenarios.finds import Find, load, scenarios_of, searched_on, without
from sensorless.envs.scenarios.machines_suite import is_on_machines, machine, on_machine
from sensorless.envs.scenarios.scenario import RUNAWAY, Scenarios
from sensorless.envs.scenarios.suites import MOST_SCENARIOS, SuiteRows
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

FOUND = re.compile(r"(.+\.json):(\d+)(:min)?")
"""Word of a scenario that a search found."""
LONGEST = 1000.0
"""Longest plan [s]."""
STEEPEST = 1e9
"""Slopes of a speed reference are below this [r/min/s]: what is steeper is a step."""
RUNAWAY_WORDS = f"{RUNAWAY:g} times rated speed, beyond which a drive counts as run away"
OVERLOAD = 2.0
"""Largest load of a plan over the torque at the current limit: no drive holds more than that."""
OVERLOAD_WORDS = f"{OVERLOAD:g} times the torque at the current limit, which no drive exceeds"


def scenario_from(word: str, motor: Motor) -> Scenarios:
    """Return one scenario from a word.

    It is SUITE:SEED:INDEX[:SIZE], as an evaluation lists it, or FILE.json:INDEX[:min], a scenario
    that a search found, with ``min`` what it needs to be lost and all else nominal.

    Raises
    ------
    UserError
        The word has another form, names no suite, lacks a size that the suite needs, or has an
        index beyond its size.
    """
    found = FOUND.fullmatch(word)
    if found is not None:
        return _found(Path(found[1]), int(found[2]), found[3] is not None, motor)
    match = re.fullmatch(r"([a-z][a-z0-9-]*):(\d+):(\d+)(?::(\d+))?", word)
    if match is None:
        raise UserError(
            f"scenario: {word!r} cannot be read; write SUITE:SEED:INDEX[:SIZE], such as hold:7:12"
        )
    name, seed, index = match[1], int(match[2]), int(match[3])
    size = int(match[4]) if match[4] else index + 1
    if name == "envelope" and match[4] is None:
        raise UserError(f"scenario: {word!r} depends on its suite's size; append :SIZE")
    if index >= size:
        raise UserError(f"scenario: {word!r}; give an INDEX below SIZE")
    if index >= MOST_SCENARIOS:
        raise UserError(f"scenario: {word!r}; give an INDEX below {MOST_SCENARIOS}")
    return SuiteRows(name, motor, seed, size)[index : index + 1].draw()


def own_machine(word: str) -> tuple[Motor | None, str]:
    """Machine that a word of the suite ``machines``, or a find on one, is about; and its scenario.

    None: that of the command.
    """
    if is_on_machines(word):
        return on_machine(word)
    found = FOUND.fullmatch(word)
    if found is not None:
        own = _find(Path(found[1]), int(found[2])).machine
        return (machine(*own) if own is not None else None), word
    return None, word


def found_elsewhere(word: str, motor: Motor, estimator: str) -> str:
    """Say that a find is of another motor or estimator than this run's, or nothing."""
    found = FOUND.fullmatch(word)
    if found is None or _find(Path(found[1]), int(found[2])).machine is not None:
        return ""
    on = searched_on(Path(found[1]))
    if on in (("", ""), (motor.name, estimator)):
        return ""
    return (
        f"{found[1]}: found on motor {on[0]} with estimator={on[1]}; this run is on {motor.name} "
        f"with estimator={estimator}; give --motor and --set to have the drive of the search"
    )


def _found(path: Path, index: int, minimal: bool, motor: Motor) -> Scenarios:
    find = _find(path, index)
    if minimal and find.lost_at is None:
        raise UserError(f"scenario: {str(path)!r}: {index} was not lost; leave out :min")
    s = scenarios_of([find], motor)
    return without(s, find.nominal, motor) if minimal else s


def _find(path: Path, index: int) -> Find:
    finds = load(path)
    if index >= len(finds):
        raise UserError(f"scenario: {str(path)!r} has {len(finds)} scenarios; give a lower INDEX")
    return finds[index]


def fig9(motor: Motor) -> str:
    """Speeds of Fig. 9 of the source paper, as shares of rated speed, which is 1500 r/min there."""
    share = motor.n_rated_rpm / 1500.0
    return ",".join(f"{t}:{share * n:.4g}" for t, n in enumerate((200.0, 350.0, 600.0)))


def plan_from(
    speed: str,
    load: str,
    ramp: float | None,
    duration: float,
    motor: Motor,
    seed: int,
    *,
    start: bool = False,
    theta_err: float = 0.0,
    spin: float = 0.0,
) -> Scenarios:
    """Return one scenario from plans of speed [r/min] and load [N m].

    Parameters
    ----------
    speed, load : str
        ``TIME:VALUE,TIME:VALUE,...`` in order of time [s].
    ramp : float, optional
        Slope of the speed reference [r/min/s]; without it the reference steps.
    duration : float
        Length [s].
    start : bool
        The drive has to find its rotor first.
    theta_err : float
        Truth minus the drive's first angle, which is 0, electrical [deg].
    spin : float
        Speed of the shaft at the beginning [r/min].

    Raises
    ------
    UserError
        A plan cannot be read or has too many times, or a number is out of range.
    """
    if not -180.0 <= theta_err <= 180.0:
        raise UserError(f"theta_err: {theta_err:g}; give -180 to 180 degrees")
    if not abs(spin) <= 2.0 * motor.n_rated_rpm:
        raise UserError(f"spin: {spin:g} r/min; give at most twice {motor.n_rated_rpm:g} r/min")
    if not motor.T_s <= duration <= LONGEST:
        raise UserError(
            f"duration: {duration:g} s; give {motor.T_s:g} s, one PWM period, to {LONGEST:g} s"
        )
    if ramp is not None and not 0.0 < ramp < STEEPEST:
        raise UserError(
            f"ramp: {ramp:g} r/min/s; give more than 0 and less than {STEEPEST:g}, or leave it out "
            "for steps"
        )
    check_seed(seed)
    speeds, loads = _plan("speed", speed), _plan("load", load)
    _check_most("speed", "r/min", speeds, RUNAWAY * motor.n_rated_rpm, RUNAWAY_WORDS)
    held = motor.tau_rated * motor.i_max / motor.i_rated
    _check_most("load", "N m", loads, OVERLOAD * held, OVERLOAD_WORDS)
    times = sorted({0.0} | {t for t, _ in speeds} | {t for t, _ in loads})
    if len(times) > PROFILE_N:
        raise UserError(f"speed, load: {len(times)} different times; give at most {PROFILE_N}")
    s = Scenarios.nominal(motor, combine(seed, np.arange(1)), duration)
    for j, t in enumerate(times):
        s.t[0, j] = t
        s.omega[0, j:] = RPM_TO_RAD_S * _at(speeds, t)
        s.tau[0, j:] = _at(loads, t)
    s.omega_rate[:] = np.inf if ramp is None else ramp * RPM_TO_RAD_S
    s.theta_0[:] = s.theta_err_0[:] = np.deg2rad(theta_err)  # the drive begins at 0
    s.seek[:], s.omega_0[:] = start, spin * RPM_TO_RAD_S
    return s


def _plan(name: str, text: str) -> list[tuple[float, float]]:
    try:
        points = [(float(t), float(v)) for t, _, v in (w.partition(":") for w in text.split(","))]
    except ValueError:
        points = []
    good = bool(points) and all(np.isfinite(p).all() and p[0] >= 0.0 for p in points)
    if not good or [t for t, _ in points] != sorted({t for t, _ in points}):
        why = "its times do not rise" if good else "give each a time of 0 s or more and a number"
        raise UserError(
            f"{name}: {text!r} cannot be read: {why}; write TIME:VALUE,TIME:VALUE,... such as 0:200"
        )
    return points


def _check_most(
    name: str, unit: str, points: list[tuple[float, float]], most: float, why: str
) -> None:
    """Raise UserError where a value of a plan is beyond the most, of either sign."""
    value = max((v for _, v in points), key=abs)
    if abs(value) > most:
        raise UserError(f"{name}: {value:g} {unit}; give at most {most:g} {unit}, {why}")


def _at(points: list[tuple[float, float]], t: float) -> float:
    """Value of the last point not after t; 0 before the first."""
    return next((v for when, v in reversed(points) if when <= t), 0.0)

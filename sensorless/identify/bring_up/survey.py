"""How often the check finds each mistake, and how often it finds one where there is none."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensorless.core.api import TRACE_NAMES, Array, ffi, lib, sim_trace
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.identify.bring_up.check import check, drives_at_rest
from sensorless.identify.bring_up.mistakes import MISTAKES, RIGHT
from sensorless.machine.motor import Motor
from sensorless.units import wrapped

TURNING = 0.3
"""Speed at which a turn of the shaft is counted, over rated."""
SECONDS = 20.0
"""Longest count."""


@dataclass(frozen=True)
class Counted:
    """Outcome of one mistake on many drives."""

    drives: int
    flagged: int
    """any bit was set"""
    named: int
    """and one of them names the mistake"""


def survey(motor: Motor, seeds: Array) -> Iterator[tuple[str, Counted]]:
    """``right`` and every mistake of ``MISTAKES``, on the drives of ``drives_at_rest``."""
    drives = drives_at_rest(motor, seeds)
    for name, mistake in (("right", RIGHT), *MISTAKES.items()):
        found = [check(motor, drives[j : j + 1], mistake)[0].faults for j in range(len(drives))]
        named = sum(bool(set(faults) & set(mistake.shows)) for faults in found)
        yield name, Counted(len(drives), sum(map(bool, found)), named)


def turning_drive(motor: Motor, seed: int) -> Array:
    """One drive with the errors of the suite stress that runs at ``TURNING`` without load."""
    s = stress_scenarios(motor, np.array([seed], dtype=np.uint64))
    speed = TURNING * motor.omega_rated / motor.n_p
    s.omega_0[:], s.omega[:], s.tau[:] = speed, speed, 0.0
    s.duration[:] = SECONDS
    return SimFactory(motor, DriveDesign()).build(s, twin=False)


def count_pole_pairs(drive: Array) -> int:
    """Pole pairs that the core counts while the shaft of a drive (1,) makes a turn under control.

    ``drive`` is changed in place.
    """
    column = {name: j for j, name in enumerate(TRACE_NAMES)}
    period = float(drive["control"]["T_s"][0])
    count = ffi.new("turn_count_t *")
    lib.turn_begin(count, float(drive["drive"]["x"]["est"]["theta"][0]))
    shaft = 0.0
    while abs(shaft) < 2.0 * np.pi:
        rows = sim_trace(drive, 100, 1.0)
        if not len(rows):
            break
        angles = rows[:, column["theta_e"]] - rows[:, column["theta_e_err"]]
        for angle in wrapped(angles):
            lib.turn_count(count, angle)
        shaft += period * float(rows[:, column["omega_m"]].sum())
    return int(lib.turn_pole_pairs(count, shaft / (2.0 * np.pi)))

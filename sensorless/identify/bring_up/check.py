"""Runs the check and reads its result."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sensorless.core.api import Array, lib
from sensorless.core.bring_up import FAULTS, WIRINGS, bring_up_replay, bring_up_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import bring_up_record
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.identify.bring_up.mistakes import RIGHT, Mistake
from sensorless.identify.bring_up.pulses import shows_others
from sensorless.machine.motor import Motor
from sensorless.observers.bring_up_design import KNEE
from sensorless.recording import read_recording

COLUMNS = ("i_a", "i_b")
"""Of a log: the samples of every PWM period from the first call of ``bring_up_step`` on."""


@dataclass(frozen=True)
class Found:
    """Result of the check."""

    faults: tuple[str, ...]
    """bits that are set, by name; none: integrated correctly"""
    wiring: str
    delay: float
    """of the voltage after its sample [periods]"""
    scale: float
    """voltage in force over the commanded one; 0: not measured"""
    lost: float
    """voltage lost by dead time over what the motor file says; 1: not judged"""
    R_s: float
    """[ohm]; 0: not measured"""
    other_pulses: bool = False
    """a log has pulses, but not when this motor's check makes them"""

    @classmethod
    def of(cls, state: Array) -> "Found":
        """Read the core's record."""
        bits = int(state["fault"])
        faults = tuple(name for name, bit in FAULTS.items() if bits & bit)
        delay, scale, lost, R_s = (float(state[name]) for name in ("delay", "scale", "lost", "R_s"))
        return cls(faults, WIRINGS[int(state["wiring"])], delay, scale, lost, R_s)


def params_of(motor: Motor) -> Array:
    """``bring_up_params_t`` of a motor, shape (1,)."""
    return bring_up_record(motor).reshape(1)


def drives_at_rest(motor: Motor, seeds: Array) -> Array:
    """Simulated drives with the errors and details of the suite stress, at rest at any angle."""
    s = stress_scenarios(motor, seeds)
    still = Scenarios.nominal(motor, seeds, 1.0)
    for name in ("t", "omega", "omega_rate", "tau", "tau_rate", "omega_0", "duration"):
        setattr(s, name, getattr(still, name))
    s.u_dc = np.repeat(s.u_dc.min(axis=1, keepdims=True), s.u_dc.shape[1], axis=1)
    return SimFactory(motor, DriveDesign()).build(s, twin=False)


def check(motor: Motor, drive: Array, mistake: Mistake = RIGHT) -> tuple[Found, Array]:
    """Run the check on a drive (1,) that is built in with a mistake; ``drive`` stays as it is.

    Returns the result and the rows of ``core.bring_up.bring_up_run``.
    """
    built = mistake.record(KNEE * motor.i_rated)
    state, rows = bring_up_run(drive.copy(), built, params_of(motor))
    return Found.of(state), rows


def write_log(rows: Array, path: Path) -> None:
    """Write what firmware logs, whole or not at all."""
    lines = [",".join((*COLUMNS, "u_alpha", "u_beta"))]
    write_atomic(path, "\n".join([*lines, *(",".join(f"{x:.9g}" for x in r) for r in rows)]) + "\n")


def check_log(motor: Motor, path: Path) -> Found:
    """Run the check on the samples of a real drive.

    Raises
    ------
    UserError
        The file cannot be read, has no such columns, or ends before the check does; it may be
        written as ``sensorless.recording`` says.
    """
    where = f"log {str(path)!r}"
    found = read_recording(path, COLUMNS, {}, where)
    if missing := [name for name in COLUMNS if name not in found.columns]:
        raise UserError(
            f"{where}: no column {missing[0]}; give i_a and i_b [A], one row per PWM period from "
            "the first call of bring_up_step on"
        )
    i_a, i_b = (found.columns[name] for name in COLUMNS)
    params = params_of(motor)
    state, used = bring_up_replay(params, i_a, i_b)
    if int(state["phase"]) != lib.BRING_UP_DONE:
        raise UserError(
            f"{where}: ends after {used} periods, before the check of motor "
            f"{motor.name!r} does; log every period until bring_up_state_t.phase is BRING_UP_DONE, "
            "and give --motor the file of the export"
        )
    return replace(Found.of(state), other_pulses=shows_others(params, i_a, i_b))

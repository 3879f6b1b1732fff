"""Runs the check and reads its result."""

import io
import re
import warnings
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
from sensorless.files import decoded, read_bytes, reason, write_atomic
from sensorless.identify.bring_up.mistakes import RIGHT, Mistake
from sensorless.identify.bring_up.pulses import shows_others
from sensorless.machine.motor import Motor
from sensorless.observers.bring_up_design import KNEE

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
        The file cannot be read, has no such columns, or ends before the check does.
    """
    try:
        with warnings.catch_warnings():  # of an empty file
            warnings.simplefilter("ignore")
            text = io.StringIO(decoded(read_bytes(path)))
            data: Array = np.genfromtxt(text, delimiter=",", names=True, dtype=np.float64)
        i_a, i_b = (np.atleast_1d(data[name]) for name in COLUMNS)
    except OSError as error:
        why = reason(error) if path.exists() else "no such file"
        raise UserError(f"log {str(path)!r}: {why}; give a file to read") from None
    except (ValueError, IndexError, TypeError) as error:
        bad = re.search(r"Line #(\d+) \(got (\d+) columns instead of (\d+)\)", str(error))
        if bad is not None:
            told = f"line {bad[1]} has {bad[2]} cells; give {bad[3]}, as in the heading"
            raise UserError(f"log {str(path)!r}: {told}") from None
        raise UserError(
            f"log {str(path)!r}: not a CSV table with the columns i_a and i_b [A], one row per "
            "PWM period from the first call of bring_up_step on"
        ) from None
    good = np.isfinite(i_a) & np.isfinite(i_b)
    if not good.all():
        k = int(np.argmin(good))
        told = f"row {k + 1} below the heading: i_a = {i_a[k]:g}, i_b = {i_b[k]:g}"
        raise UserError(f"log {str(path)!r}: {told}; give finite currents in A")
    params = params_of(motor)
    state, used = bring_up_replay(params, i_a, i_b)
    if int(state["phase"]) != lib.BRING_UP_DONE:
        raise UserError(
            f"log {str(path)!r}: ends after {used} periods, before the check of motor "
            f"{motor.name!r} does; log every period until bring_up_state_t.phase is BRING_UP_DONE, "
            "and give --motor the file of the export"
        )
    return replace(Found.of(state), other_pulses=shows_others(params, i_a, i_b))

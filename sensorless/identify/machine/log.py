"""What the drive measured: one part for each run of commands, and its file.

A log is a CSV file with a heading. Rows belong together by ``part``, the number of the run, and
``stage``, what the run is for. docs/identify.md describes the columns.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.recording import read_recording

NUMBERS = ("segment", "u_alpha", "u_beta", "u_dc", "i_a", "i_b", "theta", "omega")
"""Columns of a part, in the order of COMMISSION_* in ``core/sim/commission.h``."""
TURN, SAME = 6.3, 1.5
"""Angle by which a shaft has to turn to be compared with its speed [rad], and the largest quotient
of both that is no other unit: noise makes some percent."""
COLUMNS = ("part", "stage", *NUMBERS)
BEYOND = 3.0
"""Largest plausible reading, over the converter's range or the trip, and over the DC link; the
least of the link is a third."""


@dataclass(frozen=True)
class Part:
    """One run of commands, a row per PWM period."""

    stage: str
    rows: Floats
    """(n, 8) as ``NUMBERS``: V, A, rad and rad/s"""

    def __getitem__(self, name: str) -> Floats:
        """One column, (n,)."""
        return np.asarray(self.rows[:, NUMBERS.index(name)])

    @property
    def u(self) -> Floats:
        """(n,) voltage commanded for the period after each sample, alpha + j beta [V]."""
        return np.asarray(self["u_alpha"] + 1j * self["u_beta"])


def write_log(parts: Sequence[Part], path: Path) -> None:
    """Write all parts, whole or not at all; every number reads back as it was."""
    lines = [",".join(COLUMNS)]
    for number, part in enumerate(parts):
        form = f"{number},{part.stage},%d" + ",%.9g" * (len(NUMBERS) - 1)
        lines += [form % tuple(row) for row in part.rows.tolist()]
    write_atomic(path, "\n".join(lines) + "\n")


def read_log(path: Path) -> list[Part]:
    """Parts of a file, which may be written as ``sensorless.recording`` says.

    Raises
    ------
    UserError
        The file cannot be read, a column is missing, or a cell is no number.
    """
    where = f"log {str(path)!r}"
    found = read_recording(path, ("part", *NUMBERS), {}, where, words="stage")
    known = {*found.columns, *(["stage"] if found.words else [])}
    missing = [name for name in COLUMNS if name not in known]
    if missing:
        raise UserError(f"{where}: no column {missing[0]}; give {', '.join(COLUMNS)}")
    with np.errstate(over="ignore"):
        table = np.stack([found.columns[name] for name in NUMBERS], axis=-1).astype(np.float32)
    if not (finite := np.isfinite(table)).all():
        row, column = np.argwhere(~finite)[0]
        value = found.columns[NUMBERS[column]][row]
        raise UserError(
            f"{where}: line {found.lines[row]}: {NUMBERS[column]} = {value:g}; give numbers that a "
            "drive can measure"
        )
    groups: dict[tuple[float, str], list[int]] = {}
    for row, key in enumerate(zip(found.columns["part"].tolist(), found.words, strict=True)):
        groups.setdefault(key, []).append(row)
    return [Part(stage, table[rows].astype(np.float64)) for (_, stage), rows in groups.items()]


def plausible(parts: list[Part], motor: Motor, path: Path) -> list[Part]:
    """Return the parts.

    Raises
    ------
    UserError
        They hold a current or a DC link that this drive cannot have measured, an angle and a speed
        that contradict each other, or commands that do not follow each other.
    """
    current, link = BEYOND * max(motor.i_trip, motor.adc_range), BEYOND * motor.u_dc
    bounds = {"i_a": (-current, current), "i_b": (-current, current)}
    bounds["u_dc"] = (motor.u_dc / BEYOND, link)
    for part in parts:
        where = f"log {str(path)!r}, stage {part.stage}"
        for name, (low, high) in bounds.items():
            wrong = np.flatnonzero((part[name] < low) | (part[name] > high))
            if len(wrong):
                raise UserError(
                    f"{where}: {name} = {part[name][wrong[0]]:g} in row {wrong[0]} of the stage, "
                    f"{len(wrong)} of {len(part.rows)} rows beyond {low:.4g} to {high:.4g}; check "
                    "its unit, or measure again"
                )
        _require_turn(part, motor.T_s, where)
        segment, n = part["segment"], len(part.rows)
        ordered = np.diff(segment, prepend=0.0) >= 0.0  # a command that is over at once has no row
        wrong = np.flatnonzero(~(ordered & (segment < n) & (segment == np.floor(segment))))
        if len(wrong):
            raise UserError(
                f"{where}: segment = {segment[wrong[0]]:g} in row {wrong[0]} of the stage; it "
                "counts the commands of a part, from 0 on: mend it, or measure again"
            )
    return parts


def _require_turn(part: Part, T_s: float, where: str) -> None:
    """Refuse a part whose angle turns, and not as its speed says."""
    theta = np.unwrap(part["theta"])
    if np.ptp(theta) < TURN:
        return
    turned, told = theta[1:] - theta[0], T_s * np.cumsum(part["omega"][1:])  # sums, for noise
    share = float(turned @ told) / float(turned @ turned)
    if not 1.0 / SAME < share < SAME:
        raise UserError(
            f"{where}: omega is {share:.3g} times what theta turns by from row to row (every "
            f"{T_s:g} s); give theta in rad and omega in rad/s, both electrical"
        )

"""The inputs of an open-loop run of the machine alone, in CSV.

There is one row per PWM period: ``u_alpha``, ``u_beta`` [V] in the stator frame and, if the shaft
is free, ``tau_L`` [N m]. The header names the columns, in any order.
"""

import csv
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from sensorless.errors import UserError
from sensorless.files import decoded, read_bytes, reason
from sensorless.machine.magnetics import Floats

COLUMNS = ("u_alpha", "u_beta", "tau_L")


def read_inputs(path: str | Path) -> Floats:
    """Read the inputs, shape (n, 3): u_alpha, u_beta [V], tau_L [N m] (0 without that column).

    Raises
    ------
    UserError
        The file cannot be read; the message names file, line and column.
    """
    try:
        lines = decoded(read_bytes(Path(path))).splitlines(keepends=True)
        return _parse(lines, f"inputs {str(path)!r}")
    except OSError as error:
        raise UserError(
            f"inputs {str(path)!r}: {reason(error)}; give a file that can be read"
        ) from None
    except csv.Error as error:
        raise UserError(f"inputs {str(path)!r}: not a valid CSV file: {error}") from None


def _parse(lines: Iterable[str], where: str) -> Floats:
    reader = csv.reader(lines)
    header = [name.strip() for name in next(reader, [])]
    for name in header:
        if name not in COLUMNS or header.count(name) > 1:
            raise UserError(
                f"{where}: line 1: column {name!r}; give each of {', '.join(COLUMNS)} at most once"
            )
    for name in ("u_alpha", "u_beta"):
        if name not in header:
            raise UserError(
                f"{where}: line 1: column {name}: missing; known are {', '.join(COLUMNS)}"
            )
    rows = []
    for row in reader:
        if not row:
            continue
        if len(row) != len(header):
            raise UserError(
                f"{where}: line {reader.line_num}: {len(row)} values; give "
                f"{len(header)}, as in the header"
            )
        rows.append(
            [
                _value(text, name, f"{where}: line {reader.line_num}")
                for text, name in zip(row, header, strict=True)
            ]
        )
    if not rows:
        raise UserError(f"{where}: no rows; give one per PWM period, at least one")
    out = np.zeros((len(rows), len(COLUMNS)))
    out[:, [COLUMNS.index(name) for name in header]] = rows
    return out


def _value(text: str, name: str, where: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"{where}: {name}: {text!r}; give a finite number")
    return value

"""The learning curve of a training run, a row for each validation: ``progress.csv``."""

import csv
import math
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any

from sensorless.errors import UserError, shown
from sensorless.files import write_atomic

PROGRESS = "progress.csv"
COLUMNS = ("steps", "seconds", "lost_rate", "torque_dev", "torque_ripple", "objective", "best")
"""Columns of ``progress.csv``."""


def rows(folder: Path) -> list[dict[str, Any]]:
    """Learning curve of a run so far.

    Raises
    ------
    UserError
        The file is damaged; the message names line and column.
    """
    path = folder / PROGRESS
    if not path.is_file():
        return []
    try:
        with path.open(encoding="utf-8", newline="") as file:
            head, *lines = list(csv.reader(file)) or [[]]
    except (OSError, ValueError, csv.Error) as error:
        raise UserError(f"{path}: {error}; restore the file, or train anew") from None
    if tuple(head) != COLUMNS:
        raise UserError(
            f"{path}: line 1: {shown(','.join(head))}, not the columns {','.join(COLUMNS)}; "
            "restore the file, or train anew"
        )
    return [_row(line, f"{path}: line {n}") for n, line in enumerate(lines, 2) if line]


def _row(line: Sequence[str], where: str) -> dict[str, Any]:
    """One validation by column; ``steps`` is a whole number, the others are texts of numbers."""
    if len(line) != len(COLUMNS):
        raise UserError(
            f"{where}: {len(line)} values, not {len(COLUMNS)}; restore the file, or train anew"
        )
    row: dict[str, Any] = dict(zip(COLUMNS, line, strict=True))
    for name, text in row.items():
        try:
            value = int(text) if name == "steps" else float(text)
            if not math.isfinite(value):
                raise ValueError
        except ValueError:
            raise UserError(
                f"{where}: {name}: {shown(text)} is no finite number; restore the file, or train "
                "anew"
            ) from None
        row[name] = value if name == "steps" else text
    return row


def write_rows(folder: Path, curve: Sequence[Mapping[str, Any]]) -> None:
    """Write the learning curve of a run."""
    text = StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(curve)
    write_atomic(folder / PROGRESS, text.getvalue())


def cut_back(folder: Path, steps: int) -> None:
    """Remove what the learning curve has beyond the checkpoint that a run resumes from."""
    known = rows(folder)
    kept = [row for row in known if row["steps"] <= steps]
    if len(kept) < len(known):
        write_rows(folder, kept)

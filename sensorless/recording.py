"""Columns of numbers from what tools export: CSV of any kind, or MATLAB.

Read as they are: separators ``,``, ``;`` and tab, also at the end of a line; decimal commas; what a
tool writes above the header; comments with ``#`` or ``%``; a line of units below the header; units
behind a name, as in ``i_a [mA]``; other names of the columns, if the caller gives them; UTF-8,
Latin-1, and UTF-16 with its mark.
"""

import csv
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sensorless.errors import UserError, shown
from sensorless.files import decoded, read_bytes, reason
from sensorless.matlab_file import read_matlab

Floats = NDArray[np.float64]

UNITS = {
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "a": 1.0, "ma": 1e-3, "ka": 1e3, "v": 1.0,
    "mv": 1e-3, "kv": 1e3, "rad": 1.0, "deg": np.pi / 180.0, "°": np.pi / 180.0, "%": 0.01,
    "1": 1.0, "-": 1.0, "second": 1.0, "volt": 1.0, "ampere": 1.0,
}  # fmt: skip
"""Factors to the units of docs/replay.md."""
HEAD = re.compile(r"\s*(.+?)\s*[\[(]\s*([^\])]*?)\s*[\])]\s*")


@dataclass(frozen=True)
class Recording:
    """Columns by name, the line of the file of each row, and all names that the file has."""

    columns: dict[str, Floats]
    lines: NDArray[np.int64]
    names: Sequence[str]
    words: tuple[str, ...] = ()
    """cells of the column of words, if one was asked for"""


def read_recording(
    path: Path, wanted: Sequence[str], names: Mapping[str, str], where: str, words: str = ""
) -> Recording:
    """Read the columns that are ``wanted``; others may hold anything.

    Parameters
    ----------
    names : mapping
        Name in the file of a wanted column, with ``-`` in front if its sign is to be turned.
    words : str
        Name of a column whose cells are words; empty: none. A MATLAB file has none.

    Raises
    ------
    UserError
        The file cannot be read; the message names file, line and column.
    """
    unknown = [name for name in names if name not in wanted]
    if unknown:
        raise UserError(f"map: {unknown[0]!r} is no column; known are {', '.join(wanted)}")
    try:
        if path.suffix.lower() == ".mat":
            return _matlab(path, wanted, names, where)
        text = decoded(read_bytes(path))
    except OSError as error:
        raise UserError(f"{where}: {reason(error)}; give a file that can be read") from None
    if "\0" in text:
        raise UserError(f"{where}: not a valid CSV file; give text, or a .mat file")
    return _text(text, wanted, names, where, words)


def _text(
    text: str, wanted: Sequence[str], names: Mapping[str, str], where: str, words: str
) -> Recording:
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and line.lstrip()[0] not in "#%"
    ]
    sought = {names.get(name, name).removeprefix("-").strip() for name in wanted}
    top = next((j for j, (_, line) in enumerate(lines) if _names(line, sought)), 0)
    lines = lines[top:]
    mark = _mark(lines[0][1]) if lines else ","
    try:
        cells = list(csv.reader((line for _, line in lines), delimiter=mark))
    except csv.Error as error:
        raise UserError(f"{where}: not a valid CSV file: {error}") from None
    if len(cells) != len(lines):
        raise UserError(f"{where}: a quote in a line does not end there; leave quotes out")
    header = [name.strip() for name in cells[0]] if cells else []
    used = _used(header, wanted, names, where, lines[0][0] if lines else 1)
    whole = {given.removeprefix("-").strip() for given in names.values()}
    units = {
        name: _unit(header[j], f"{where}: line {lines[0][0]}", header[j] in whole)
        for name, (j, _) in used.items()
    }
    body = list(zip([number for number, _ in lines[1:]], cells[1:], strict=True))
    if body and not any(_is_number(cell) for cell in body[0][1]):  # a line of units
        for name, (j, _) in used.items():
            word = body[0][1][j] if j < len(body[0][1]) else ""
            if word := word.strip(" []()"):
                units[name] = _factor(word, f"{where}: line {body[0][0]}", header[j])
        body = body[1:]
    rows = []
    for number, row in body:
        while len(row) > len(header) and not row[-1].strip():
            row = row[:-1]
        if len(row) != len(header):
            at = f"{where}: line {number}"
            raise UserError(f"{at}: {len(row)} values; give {len(header)}, as in the header")
        rows.append(row)
    if not rows:
        raise UserError(f"{where}: no rows; give one per PWM period, at least 3")
    numbers = np.array([number for number, _ in body])
    columns = {}
    for name, (j, sign) in used.items():
        cells_of = [row[j] for row in rows]
        columns[name] = sign * units[name] * _values(cells_of, numbers, where, header[j])
    told = header.index(words) if words in header else None
    said = () if told is None else tuple(row[told].strip() for row in rows)
    return Recording(columns, numbers, header, said)


def _mark(line: str) -> str:
    """Separator of a line."""
    return next((mark for mark in ";\t" if mark in line), ",")


def _names(line: str, sought: Collection[str]) -> bool:
    """Whether a line is the header: at least two of its cells are names of columns."""
    bare = (_bare(cell.strip(' "')) for cell in line.split(_mark(line)))
    return sum(name in sought for name in bare) > 1


def _bare(name: str) -> str:
    """A name without the unit behind it."""
    found = HEAD.fullmatch(name)
    return found[1] if found else name


def _used(
    header: Sequence[str], wanted: Sequence[str], names: Mapping[str, str], where: str, line: int
) -> dict[str, tuple[int, float]]:
    """Place and sign of every wanted column that the file has."""
    bare = [_bare(name) for name in header]
    taken = {given.removeprefix("-").strip() for given in names.values()}
    out = {}
    for name in wanted:
        if name in taken and name not in names:
            continue  # the column is another one
        given = names.get(name, name)
        sign, given = (-1.0, given[1:].strip()) if given.startswith("-") else (1.0, given)
        places = [j for j, (b, h) in enumerate(zip(bare, header, strict=True)) if given in (b, h)]
        if len(places) > 1:
            raise UserError(f"{where}: line {line}: column {given}: given twice; give it once")
        if places:
            out[name] = (places[0], sign)
        elif name in names:
            raise UserError(
                f"{where}: line {line}: column {given}, which --map names, is missing; the file "
                f"has {', '.join(header)[:200]}"
            )
    return out


def _unit(name: str, at: str, whole: bool) -> float:
    """Factor of a unit in brackets behind a name; ``whole``: what is no unit may be of the name."""
    found = HEAD.fullmatch(name)
    if not found or not found[2] or (whole and found[2].lower() not in UNITS):
        return 1.0
    return _factor(found[2], at, name)


def _factor(unit: str, at: str, column: str) -> float:
    if unit.lower() not in UNITS:
        raise UserError(
            f"{at}: column {shown(column)}: unit {shown(unit)} is not known; give one of "
            f"{', '.join(UNITS)}"
        )
    return UNITS[unit.lower()]


def _number(text: str) -> float:
    return float(text.replace(",", "."))


def _is_number(text: str) -> bool:
    try:
        _number(text)
    except ValueError:
        return False
    return True


def _values(cells: Sequence[str], lines: NDArray[np.int64], where: str, column: str) -> Floats:
    """(n,) numbers of a column; fast where none has a decimal comma."""
    try:
        out = np.array(cells, dtype=np.float64)
    except ValueError:
        out = np.full(len(cells), np.nan)
    if not np.all(np.abs(out) < 1e15):
        pairs = zip(lines, cells, strict=True)
        out = np.array([_value(text, f"{where}: line {n}", column) for n, text in pairs])
    return out


def _value(text: str, at: str, column: str) -> float:
    try:
        value = _number(text)
    except ValueError:
        value = np.nan
    if not abs(value) < 1e15:  # also NaN
        raise UserError(f"{at}: {column}: {text!r}; give a finite number")
    return value


def _matlab(path: Path, wanted: Sequence[str], names: Mapping[str, str], where: str) -> Recording:
    """Vectors of a MATLAB file, or of the structures in it."""
    try:
        found = read_matlab(path)
    except ValueError as error:
        raise UserError(f"{where}: {error}") from None
    found = {k: v for k, v in found.items() if v.ndim == 1}
    vectors = {k: v.astype(float) for k, v in found.items() if v.dtype.kind in "fiub"}
    used = _used(list(vectors), wanted, names, where, 1)
    columns = {name: sign * list(vectors.values())[j] for name, (j, sign) in used.items()}
    if len({len(column) for column in columns.values()}) > 1:
        raise UserError(f"{where}: vectors of unequal length; give one number per PWM period each")
    for name, column in columns.items():
        if not np.all(np.abs(column) < 1e15):
            raise UserError(f"{where}: {name}: not all numbers are finite; mend or cut these rows")
    n = len(next(iter(columns.values()), ()))
    return Recording(columns, np.arange(1, n + 1), list(vectors))

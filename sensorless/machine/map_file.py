"""A flux map from a file: CSV or MATLAB, columns in any order, with or without units."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.errors import UserError, shown
from sensorless.files import decoded, read_bytes
from sensorless.machine.magnetics import Floats
from sensorless.matlab_file import read_matlab

COLUMNS = ("i_d", "i_q", "psi_d", "psi_q")
UNITS = {"a": 1.0, "ma": 1e-3, "ka": 1e3, "vs": 1.0, "wb": 1.0, "mvs": 1e-3, "mwb": 1e-3}
"""Factors to A and Vs."""
FLUX_WORDS = ("psi", "lambda", "flux", "phi")
MOST_POINTS = 200_000
"""Largest number of points of a map."""


def load_map(path: Path, columns: str | None = None, turn: bool = False) -> tuple[Floats, Floats]:
    """Currents (n, 2) [A] and flux linkages (n, 2) [Vs] of a map, d along the magnet.

    Parameters
    ----------
    path : Path
        ``.mat``: four variables, as columns, or as grids of flux over two axes of current. Else
        text: four columns under a heading, separated by commas, semicolons, tabs or blanks, and
        between all but commas with decimal commas, too; ``#`` starts a comment.
    columns : str, optional
        Names of the columns in order, for a file without a heading or with other names.
    turn : bool
        The map's d axis is that of a reluctance machine's iron, its magnet along -q.

    Raises
    ------
    UserError
        The file cannot be read, or a column is missing or holds what is no finite number.
    """
    try:
        raw = read_matlab(path) if path.suffix.lower() == ".mat" else _text(path, columns)
        found = _named(raw, path)
    except UserError:
        raise
    except (OSError, ValueError, TypeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise UserError(f"map: {path}: {reason}") from None
    i, psi = np.stack(found[:2], axis=-1), np.stack(found[2:], axis=-1)
    good = np.all(np.isfinite(i) & np.isfinite(psi), axis=1)
    if path.suffix.lower() != ".mat" and not good.all():  # a grid of MATLAB may have blank corners
        k = int(np.argmin(good))
        row = ", ".join(
            f"{name} = {x:g}" for name, x in zip(COLUMNS, (*i[k], *psi[k]), strict=True)
        )
        raise UserError(f"map: {path}: row {k + 1}: {row}; give finite numbers, or cut this row")
    i, psi = i[good], psi[good]
    if not 20 <= len(i) <= MOST_POINTS:
        raise UserError(
            f"map: {path}: points with four finite numbers: {len(i)}; give 20 to {MOST_POINTS}"
        )
    if turn:
        i, psi = (np.stack([-x[:, 1], x[:, 0]], axis=-1) for x in (i, psi))
    return i, psi


def _text(path: Path, columns: str | None) -> dict[str, Any]:
    """Columns by heading."""
    text = decoded(read_bytes(path))
    if "\0" in text:
        raise ValueError("not a text file; give CSV, or MATLAB under a name that ends in .mat")
    lines = text.splitlines()
    rows = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not rows:
        raise ValueError("the file has no numbers; give a flux map")
    top = rows[0].strip().rstrip(",;")
    heads = re.split(r"[,;\t]", top) if re.search(r"[,;\t]", top) else top.split()
    blanks = len(heads) > 1 and not re.search(r"[,;\t]", top)
    if columns is not None:
        names = [name.strip() for name in columns.split(",")]
        rows = rows if _is_number(heads[0]) else rows[1:]
    elif _is_number(heads[0]):
        raise ValueError(f"no heading; name the columns: --columns {','.join(COLUMNS)}")
    else:
        names, rows = [head.strip(' "') for head in heads], rows[1:]
    if not rows:
        raise ValueError("no numbers under the heading; give a flux map")
    table = np.array([_numbers(row, len(names), blanks) for row in rows])
    return {name: table[:, k] for k, name in enumerate(names)}


def _numbers(row: str, n: int, blanks: bool) -> list[float]:
    """The ``n`` numbers of a row; ``blanks`` alone separate the column names."""
    cells = _cells(row.strip().rstrip(",;"), blanks)
    if len(cells) != n:
        more = ", and a semicolon between two where the decimal sign is a comma"
        raise ValueError(
            f"row {shown(row)}: {len(cells)} numbers; give {n}, one for each column name"
            + (more if len(cells) > n and "," in row else "")
        )
    try:
        return [float(cell) for cell in cells]
    except ValueError as error:
        raise ValueError(f"row {shown(row)}: {error}; give {n} numbers") from None


def _cells(row: str, blanks: bool) -> list[str]:
    """Texts of a row; a comma is the decimal sign where another sign is between the numbers."""
    if ";" in row:
        cells = row.replace(",", ".").split(";")
    elif "\t" in row or (blanks and not re.search(r",\s", row) and len(row.split()) > 1):
        cells = row.replace(",", ".").split()
    else:
        cells = re.split(r"\s*,\s*|\s+", row)
    return [cell.strip(' "') for cell in cells]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _named(raw: Mapping[str, Any], path: Path) -> list[Floats]:
    """The four columns in order, in A and Vs, flat and of one length."""
    out: dict[str, Floats] = {}
    for name, value in raw.items():
        key, factor = _meaning(name)
        if key in out:
            raise UserError(f"map: {path}: {key} twice; give each column once")
        if key:
            out[key] = factor * np.asarray(value, dtype=float)
    missing = [name for name in COLUMNS if name not in out]
    if missing:
        raise UserError(
            f"map: {path}: no column {missing[0]}; found {', '.join(raw)[:200]}; name them "
            f"{', '.join(COLUMNS)}, with a unit in brackets if need be, e.g. psi_d [mVs]"
        )
    return _laid_out([out[name] for name in COLUMNS], path)


def _meaning(name: str) -> tuple[str, float]:
    """Column that a heading names, empty if it names none, and the factor of its unit."""
    match = re.match(r"\s*([A-Za-z]+?)_?(?:s_)?([dq])\b\s*[\[(]?\s*([A-Za-z]*)", name)
    if match is None:
        return "", 1.0
    quantity, axis, unit = match[1].lower(), match[2], match[3].lower()
    if quantity == "i":
        kind = "i"
    elif quantity in FLUX_WORDS:
        kind = "psi"
    else:
        return "", 1.0
    if unit and unit not in UNITS:
        raise ValueError(
            f"{name.strip()!r}: unknown unit; write one of A, mA, kA, Vs, mVs, Wb, mWb"
        )
    return f"{kind}_{axis}", UNITS.get(unit, 1.0)


def _laid_out(parts: list[Floats], path: Path) -> list[Floats]:
    """Currents and fluxes point by point; axes of a grid become the currents of its points."""
    i_d, i_q, psi_d, psi_q = parts
    if i_d.ndim == 1 and i_q.ndim == 1 and psi_d.ndim == 2:
        grids = np.meshgrid(i_d, i_q, indexing="ij"), np.meshgrid(i_d, i_q, indexing="xy")
        fits = [pair for pair in grids if pair[0].shape == psi_d.shape == psi_q.shape]
        if not fits:
            raise UserError(
                f"map: {path}: fluxes of shape {psi_d.shape} over {len(i_d)} i_d and {len(i_q)} "
                "i_q; give one flux for each pair of currents"
            )
        best = max(fits, key=lambda pair: _follows(pair[0], psi_d) + _follows(pair[1], psi_q))
        i_d, i_q = best
    flat = [np.ravel(x) for x in (i_d, i_q, psi_d, psi_q)]
    if len({len(x) for x in flat}) != 1:
        lengths = ", ".join(str(len(x)) for x in flat)
        raise UserError(f"map: {path}: columns of {lengths} numbers; give columns of one length")
    return flat


def _follows(i: Floats, psi: Floats) -> float:
    """Correlation of current and flux: shows which axis of a square grid is which.

    Blank corners have no say.
    """
    good = np.isfinite(i) & np.isfinite(psi)
    return float(np.corrcoef(i[good], psi[good])[0, 1])

"""The schedule table as a text file; reading it restores every float32 bit."""

import json
import math
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sensorless.errors import UserError
from sensorless.files import read_json
from sensorless.table.gain_grid import FIELDS as GAIN_FIELDS

FORMAT = "sensorless-ks-table/1"
"""A table of k_s alone."""
FORMAT_GAINS = "sensorless-ks-table/2"
"""A table that also sets gains, in a further field."""
FIELDS = ("axes", "slew_per_s", "fallback", "rule", "values")
AXIS_FIELDS = ("signal", "lo", "hi", "n")


def content(fields: Mapping[str, Any]) -> bytes:
    """Return all numbers of a table as one canonical text, for checksum and digest."""
    return json.dumps(fields, sort_keys=True, separators=(",", ":")).encode()


def is_table(path: Path) -> bool:
    """Whether a file says that it is a table; one that cannot be read is none."""
    try:
        data = read_json(path)
    except (OSError, ValueError):
        return False
    return isinstance(data, dict) and data.get("format") in (FORMAT, FORMAT_GAINS)


def to_text(fields: Mapping[str, Any], provenance: Mapping[str, Any]) -> str:
    """Return the file's text, with one line for each row of nodes along the last axis."""
    head = {
        "format": FORMAT_GAINS if "gains" in fields else FORMAT,
        "crc32": f"0x{zlib.crc32(content(fields)):08x}",
        "provenance": _plain(provenance),
    }
    parts = [
        f'  "{key}": {json.dumps(value, indent=2)}'.replace("\n", "\n  ")
        for key, value in head.items()
    ]
    parts += [f'  "{key}": {json.dumps(fields[key])}' for key in FIELDS if key != "values"]
    parts.append(f'  "values": {_rows(fields["values"], "    ")}')
    if "gains" in fields:
        grids = ",\n".join(_grid(grid) for grid in fields["gains"])
        parts.append(f'  "gains": [\n{grids}]')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _grid(fields: Mapping[str, Any]) -> str:
    head = [f'"{key}": {json.dumps(fields[key])}' for key in GAIN_FIELDS if key != "values"]
    values = f'"values": {_rows(fields["values"], "      ")}'
    return "    {" + ", ".join([*head, values]) + "}"


def _plain(x: object) -> object:
    """Convert to JSON types; a number that is not finite becomes a string."""
    if isinstance(x, Mapping):
        return {str(key): _plain(value) for key, value in x.items()}
    if isinstance(x, (list, tuple)):
        return [_plain(value) for value in x]
    return str(x) if isinstance(x, float) and not math.isfinite(x) else x


def _rows(values: Any, indent: str) -> str:
    if not isinstance(values[0], list):
        return json.dumps(values)
    return "[\n" + ",\n".join(indent + _rows(v, indent + "  ") for v in values) + "]"


def from_text(text: str, where: str) -> tuple[dict[str, Any], dict[str, Any], str]:
    """Fields, provenance and stored checksum of a file's text; its numbers are not checked here.

    Raises
    ------
    UserError
        The text is not a table of this format.
    """
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise UserError(f"{where}: {error}; give a table in JSON") from None
    found = data.get("format") if isinstance(data, dict) else type(data).__name__
    if found not in (FORMAT, FORMAT_GAINS) or not isinstance(data, dict):
        raise UserError(f"{where}: format {found!r} is not {FORMAT!r}; write the table again")
    names = FIELDS if found == FORMAT else (*FIELDS, "gains")
    _exactly(data, ("format", "crc32", "provenance", *names), where)
    if not isinstance(data["provenance"], dict):
        raise UserError(f"{where}: provenance: {data['provenance']!r}; give an object")
    for name, known in (("axes", AXIS_FIELDS), ("gains", GAIN_FIELDS)):
        parts = data.get(name, [])
        if not isinstance(parts, list):
            raise UserError(f"{where}: {name}: {parts!r}; give a list of {name}")
        for part in parts:
            if not isinstance(part, dict):
                raise UserError(f"{where}: {name}: {part!r}; give an object")
            _exactly(part, known, f"{where}: {name}")
    return {key: data[key] for key in names}, data["provenance"], str(data["crc32"])


def check_crc(fields: Mapping[str, Any], stored: str, where: str) -> None:
    """Compare the checksum over fields as they were read with the stored one.

    Raises
    ------
    UserError
        The file was changed after it was written.
    """
    crc = f"0x{zlib.crc32(content(fields)):08x}"
    if stored != crc:
        raise UserError(
            f"{where}: crc32: {stored!r} is not {crc!r}, the checksum of the table's numbers: the "
            "file was changed or damaged; restore it"
        )


def _exactly(data: Mapping[str, Any], names: tuple[str, ...], where: str) -> None:
    for name in names:
        if name not in data:
            raise UserError(f"{where}: {name}: missing; give {', '.join(names)}")
    for name in data:
        if name not in names:
            raise UserError(f"{where}: {name}: unknown field; known are {', '.join(names)}")

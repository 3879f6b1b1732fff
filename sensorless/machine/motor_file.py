"""How a motor file is written: tables, units, and the source of every number."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sensorless.errors import UserError
from sensorless.files import check_writable
from sensorless.machine.datasheet import Number
from sensorless.machine.motor import Motor
from sensorless.settings import settings_of

TABLES = {
    "machine": ("n_p", "R_s", "L_d", "L_q", "psi_f", "J", "B"),
    "rating": ("tau_rated", "i_rated", "n_rated_rpm", "u_dc"),
    "drive": ("T_s", "u_inj", "i_max", "i_trip", "dead_time", "adc_range", "adc_bits"),
}
WHOLE = ("n_p", "adc_bits")


def check_motor_out(out: Path | None) -> None:
    """Check before the work that a motor file can be written to ``out``, and read again.

    Raises
    ------
    UserError
        Its name does not end in .toml, or as ``check_writable``.
    """
    if out is not None and out.suffix != ".toml":
        raise UserError(f"out: {str(out)!r}: the name of a motor file ends in .toml")
    check_writable(out)


def tables(name: str, description: str, numbers: Mapping[str, Number]) -> dict[str, Any]:
    """Tables of a motor file as ``Motor.from_tables`` takes them, rounded to five digits."""
    return {
        "name": name,
        "description": description,
        **{table: {f: _value(f, numbers[f]) for f in fields} for table, fields in TABLES.items()},
        "source": {f: numbers[f].source for fields in TABLES.values() for f in fields},
    }


def _value(field: str, number: Number) -> float:
    return round(number.value) if field in WHOLE else float(f"{number.value:.5g}")


def written(data: Mapping[str, Any], head: str) -> str:
    """TOML text of a motor file: ``head`` on top, meaning and unit after each number."""
    meaning = {
        s.name: s.meaning if s.unit in ("", "1") else f"{s.meaning} [{s.unit}]"
        for s in settings_of(Motor).values()
    }
    lines = [*(f"# {line}".rstrip() for line in head.splitlines()), ""]
    for name, value in data.items():
        if not isinstance(value, Mapping):
            lines.append(f"{name} = {toml_value(value)}")
    for table, fields in data.items():
        if isinstance(fields, Mapping):
            lines += ["", *table_lines(table, fields, meaning if table in TABLES else {})]
    return "\n".join(lines) + "\n"


def table_lines(
    name: str, fields: Mapping[str, Any], meaning: Mapping[str, str] | None = None
) -> list[str]:
    """Lines of one table, each with its ``meaning`` as a comment if given."""
    out = [f"[{name}]"]
    for field, value in fields.items():
        line = f"{field} = {toml_value(value)}"
        out.append(f"{line:<22} # {meaning[field]}" if meaning else line)
    return out


def toml_value(value: object) -> str:
    """A number, a switch, a text or rows of numbers as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = value.encode("utf-8", "replace").decode()  # bytes of no sign, from a shell, become ?
        # a TOML basic string has JSON's escapes, and one more
        return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, tuple):
        rows = "".join(f"    [{', '.join(map(repr, row))}],\n" for row in value)
        return f"[\n{rows}]"
    return repr(value)

"""The command ``sensorless settings``."""

import math
from dataclasses import asdict
from typing import Any

from rich.table import Table

from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    console,
    say_json,
)
from sensorless.design.words import text_of
from sensorless.settings import Setting


def settings_command(
    motor: MotorOption = "paper",
    as_json: JsonOption = False,
) -> None:
    """List every setting of the drive design that --set changes.

    Each has a name, a default, a unit, a range or choices, and a meaning. Numbers without a unit
    are plain; a switch is true or false. What is "auto" follows from the machine: the number is
    that of --motor, and docs/gains.md has the formula.

    For example:

        sensorless settings
        sensorless settings --motor mine.toml
        sensorless settings --json
        sensorless simulate --set speed_hz=4 --set mtpa=false
    """
    from sensorless.design.derived import derive
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor
    from sensorless.settings import settings_of

    known = settings_of(DriveDesign).values()
    values = asdict(derive(Motor.load(motor), DriveDesign()))
    if as_json:
        say_json([facts(s, values.get(s.name)) for s in known])
    table = Table(box=None)
    for heading in ("name", "default", "unit", "range", "meaning or choices"):
        table.add_column(heading, no_wrap=heading != "meaning or choices")
    for s in known:
        choices = "".join(f"\n{word}: {doc}" for word, doc in s.choices.items())
        default = text_of(s.default) + (f" = {values[s.name]:.4g}" if s.derived else "")
        cells = (s.name, default, unit_of(s), range_of(s), s.meaning + choices)
        table.add_row(*cells)
    console.print(table)


def facts(setting: Setting, value: float | None) -> dict[str, Any]:
    """All about a setting in JSON types; the end of an unlimited range is null.

    ``value`` is what an automatic setting is on the machine.
    """
    out: dict[str, Any] = {"name": setting.name, "type": setting.kind.__name__}
    word = setting.default is None or setting.default == math.inf
    out["default"] = text_of(setting.default) if word else setting.default
    if setting.derived:
        out["value"] = value
    if setting.kind in (int, float):
        out["unit"] = setting.unit
        out["low"] = setting.low
        out["high"] = setting.high if math.isfinite(setting.high) else None
        out["infinite"] = setting.endless
    elif setting.kind is str:
        out["choices"] = dict(setting.choices)
    return {**out, "meaning": setting.meaning}


def unit_of(setting: Setting) -> str:
    """Unit of a setting, empty if it has none."""
    return "" if setting.unit == "1" else setting.unit


def range_of(setting: Setting) -> str:
    """Range of a number; empty for a switch or a word."""
    if setting.kind not in (int, float):
        return ""
    if math.isfinite(setting.high) or setting.endless:
        return f"{setting.low:.12g} to {setting.high:.12g}"
    return f"{setting.low:.12g} or more"

"""A drive design from the words of ``--set``."""

import dataclasses

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError


def design_from(settings: list[str] | None) -> DriveDesign:
    """Drive design from words NAME=VALUE over the defaults.

    Raises
    ------
    UserError
        Unknown name, or a value of the wrong type or out of range.
    """
    fields = {f.name: f for f in dataclasses.fields(DriveDesign)}
    values: dict[str, float | bool | str] = {}
    for word in settings or []:
        name, _, text = word.partition("=")
        if name not in fields:
            raise UserError(
                f"set: {word!r}; allowed: NAME=VALUE with NAME one of {', '.join(fields)}"
            )
        values[name] = _value(name, text, fields[name].default)
    return DriveDesign(**values)  # type: ignore[arg-type]


def _value(name: str, text: str, default: object) -> float | bool | str:
    if isinstance(default, bool):
        if text not in ("true", "false"):
            raise UserError(f"{name}: {text!r}; allowed: true, false")
        return text == "true"
    if isinstance(default, str):
        return text
    try:
        return float(text)
    except ValueError:
        raise UserError(f"{name}: {text!r}; allowed: a number") from None

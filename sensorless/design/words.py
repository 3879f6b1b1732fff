"""A drive design from the words of ``--set``, and the names of observers in texts."""

from collections.abc import Sequence
from typing import Any

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError, like
from sensorless.settings import AUTO, refuse_old, settings_of

OBSERVERS = {
    "smo": "SMO",
    "unwrapped": "SMO",
    "errors": "SMO",
    "flux": "flux observer",
    "coupled": "coupled observer",
}
"""Name of the observer that leads at k_s = 0, by ``DriveDesign.estimator``; SMO: sliding-mode."""


def observer_name(estimator: str) -> str:
    """Name of the observer of a drive with this estimator, for pictures and tables."""
    return OBSERVERS[estimator]


def design_from(words: Sequence[str] | None) -> DriveDesign:
    """Drive design from words NAME=VALUE over the defaults; errors as in ``asked_for``."""
    return DriveDesign(**asked_for(words))


def asked_for(words: Sequence[str] | None) -> dict[str, Any]:
    """Settings of the drive design by name from words NAME=VALUE.

    Raises
    ------
    UserError
        Unknown or old name, one given twice, or a value of the wrong type or out of range.
    """
    known = settings_of(DriveDesign)
    values = {}
    for word in words or ():
        name, equals, text = word.partition("=")
        if name not in known:
            refuse_old(name, known, "set: ")
            hint = like(name, known)
            raise UserError(f"set: {word!r}: no such setting: {hint}sensorless settings lists all")
        if not equals:
            raise UserError(f"set: {word!r}: no value: write {name}=VALUE")
        if name in values:
            raise UserError(f"set: {name}: given twice; give it once")
        values[name] = known[name].parsed(text)
    return values


def words_of(design: DriveDesign) -> list[str]:
    """Words NAME=VALUE of all settings that are not the default."""
    default = DriveDesign()
    return [
        f"{name}={text_of(getattr(design, name))}"
        for name in settings_of(DriveDesign)
        if getattr(design, name) != getattr(default, name)
    ]


def text_of(value: float | bool | str | None) -> str:
    """Value of a setting as --set takes it."""
    if value is None:
        return AUTO
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else f"{value:.12g}"

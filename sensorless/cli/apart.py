"""Refuses, before any work, to write over a file of the same command, or over a motor file."""

import os
from collections.abc import Iterator, Mapping
from typing import Any

from sensorless.errors import UserError

WRITTEN = ("out", "plot", "save_log")
"""Parameters of commands that name a file to write."""
READ = (
    "motor", "policy", "run", "file", "log", "plant", "inputs", "scenario", "settings", "names",
)  # fmt: skip
"""Parameters that may name a file to read, alone or inside a word such as cross=FILE.json."""
REPLACE = "replace"
"""Flag of the commands that may replace a motor file."""
BY_HAND = ".toml"
"""Ending of motor files, which a user may have corrected; all others that are written can be made
again, and are replaced."""


def keep_apart(given: Mapping[str, Any], names: Mapping[str, str]) -> None:
    """Check the values of a command's parameters.

    Parameters
    ----------
    names : mapping
        What the user calls each parameter.

    Raises
    ------
    UserError
        A file to write is another file of the command; the message names both parameters.
    """
    others = [(key, path) for key in READ for path in _files(given.get(key))]
    for key in WRITTEN:
        path = given.get(key)
        if path is None or (os.path.exists(path) and not os.path.isfile(path)):
            continue  # a folder, or a device
        for other, known in others:
            if _same(path, known):
                raise UserError(
                    f"{names[key].lstrip('-')}: {str(path)!r} is also the file of {names[other]}; "
                    "write to another one"
                )
        others.append((key, path))


def keep_motor_files(given: Mapping[str, Any], names: Mapping[str, str]) -> None:
    """Check that no parameter names an existing motor file to write that may not be replaced.

    Raises
    ------
    UserError
        Names the parameter and the file.
    """
    for key in WRITTEN:
        path = given.get(key)
        if path is None or given.get(REPLACE) or not os.path.isfile(path):
            continue
        if BY_HAND in (os.path.splitext(x)[1] for x in (path, os.path.realpath(path))):
            more = ", or add --replace" if REPLACE in given else ""
            raise UserError(
                f"{names[key].lstrip('-')}: {str(path)!r} exists; write to another file{more}"
            )


def _files(value: Any) -> Iterator[str]:
    """Files that a parameter names: FILE, NAME=FILE, FILE:INDEX or tuned:FILE."""
    for word in value if isinstance(value, list | tuple) else [value]:
        text = str(word)
        parts = (text, text.partition("=")[2], *text.partition(":")[::2])
        yield from (part for part in parts if os.path.isfile(part))


def _same(a: Any, b: Any) -> bool:
    if os.path.realpath(a) == os.path.realpath(b):
        return True
    try:
        return os.path.samefile(a, b)
    except OSError:
        return False

"""Names that a file has for the columns of a log: words of the command line, or a small TOML."""

import sys
from collections.abc import Sequence
from pathlib import Path

from sensorless.errors import UserError
from sensorless.files import read_bytes, reason

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def names_from(words: Sequence[str] | None) -> dict[str, str]:
    """Name in the file by column, from ``NAME=COLUMN`` and TOML files with lines of the same.

    Raises
    ------
    UserError
        A word is neither, a column is named twice, or a file cannot be read.
    """
    names: dict[str, str] = {}
    for word in words or ():
        name, equals, column = word.partition("=")
        if equals:
            more = {name.strip(): column.strip()}
        elif word.endswith(".toml"):
            more = _from_file(Path(word))
        else:
            raise UserError(f"map: {word!r}; give NAME=COLUMN, as in i_a=Ia, or a .toml file")
        for name, column in more.items():
            if name in names:
                raise UserError(f"map: {name}: given twice; give it once")
            if not column.removeprefix("-").strip():
                raise UserError(f"map: {name}: no column; give NAME=COLUMN, as in i_a=Ia")
        names |= more
    return names


def _from_file(path: Path) -> dict[str, str]:
    try:
        data = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise UserError(f"map: {str(path)!r}: {reason(error)}") from None
    except (ValueError, RecursionError) as error:
        raise UserError(f"map: {str(path)!r}: not a valid TOML file: {error}") from None
    for name, column in data.items():
        if not isinstance(column, str):
            raise UserError(
                f"map: {str(path)!r}: {name}: {column!r}; give the column's name as a text"
            )
    return data

"""Puts an export in its place: a new folder or an earlier export, never over anything else."""

import hashlib
from collections.abc import Mapping
from pathlib import Path

from sensorless.errors import UserError
from sensorless.files import read_json

TABLE_JSON = "ks_table.json"
SUMS = "SHA256SUMS"
BUILD = "build"
"""Folder in which the export's own Makefile builds."""


def check_replaceable(folder: Path) -> None:
    """Refuse a folder that holds anything but an earlier export.

    Raises
    ------
    UserError
        The folder holds other files; the message names one.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise UserError(f"output folder {str(folder)!r} is a file; give a folder")
    known = _written(folder)
    for path in folder.iterdir() if known is None else folder.rglob("*"):
        name = path.relative_to(folder)
        if known is None:
            raise UserError(
                f"output folder {str(folder)!r} has {name.name!r} and is no export; give a new or "
                "empty folder, or an earlier export"
            )
        if not path.is_dir() and name.parts[0] != BUILD and name.as_posix() not in known:
            raise UserError(
                f"output folder {str(folder)!r} has {name.as_posix()!r}, which no export wrote; "
                "move that file away, or give another folder"
            )


def _written(folder: Path) -> set[str] | None:
    """Names of the files of an earlier export; None if the folder is not one."""
    try:
        data = read_json(folder / TABLE_JSON)
        return {*data["provenance"]["export"]["sha256"], TABLE_JSON, SUMS}
    except (OSError, ValueError, KeyError, TypeError):
        return None


def sums(files: Mapping[str, bytes]) -> str:
    """``SHA256SUMS``, which ``sha256sum -c`` reads."""
    return "".join(
        f"{hashlib.sha256(content).hexdigest()}  {name}\n"
        for name, content in sorted(files.items())
    )


def write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files, given by their relative names, into a new folder."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)

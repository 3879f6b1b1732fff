"""Files that are written whole or not at all."""

import os
from pathlib import Path

from sensorless.errors import UserError


def write_atomic(path: str | Path, data: str | bytes) -> None:
    """Write a temporary file next to ``path``, then rename it; text becomes UTF-8.

    Raises
    ------
    UserError
        The folder cannot be written to; an older file of that name is unchanged.
    """
    path = Path(path)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    raw = data.encode("utf-8") if isinstance(data, str) else data
    try:
        try:
            part.write_bytes(raw)
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(f"output {str(path)!r}: {reason(error)}; write to another folder") from None


def ensure_writable(folder: str | Path) -> Path:
    """Create a folder with its parents, make sure that files can be made in it, and return it.

    Raises
    ------
    UserError
        It cannot be created or written to.
    """
    folder = Path(folder)
    probe = folder / f".probe.{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UserError(
            f"output folder {str(folder)!r}: {reason(error)}; give a folder that can be written to"
        ) from None
    return folder


def check_writable(path: str | Path | None, name: str = "out") -> None:
    """Check before a long run that a file can be written; None means no file.

    Raises
    ------
    UserError
        The folder does not exist or cannot be written to, or the path is a folder; the message
        names the option ``name``.
    """
    if path is None:
        return
    path = Path(path)
    folder = path.parent
    if not folder.is_dir():
        raise UserError(
            f"{name}: {str(path)!r}: folder {str(folder)!r} does not exist; create it, or write "
            "to another one"
        )
    if path.is_dir():
        raise UserError(f"{name}: {str(path)!r} is a folder; give the name of a file")
    probe = folder / f".{path.name}.{os.getpid()}.part"
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UserError(
            f"{name}: {str(path)!r}: {reason(error)}; write to another folder"
        ) from None


def reason(error: Exception) -> str:
    """Why a file could not be read or written, in a few words."""
    return getattr(error, "strerror", None) or str(error)

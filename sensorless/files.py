"""Files that are written whole or not at all."""

import ctypes
import errno
import json
import os
import re
import shutil
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from sensorless.errors import UserError

LONGEST = 255
"""Bytes of a name on every usual file system, checked before parents are made."""
MOST_BYTES = 2**29
"""Largest file that is read: a log of some ten minutes at 10 kHz."""
OLD = 60.0
"""Age from which what a killed process left half-written is removed [s]."""
PART = re.compile(r"\.(.+)\.(\d+)\.part(\.old)?")
"""Names of what is half-written: the final name and the process."""
EXCHANGE = 2
"""RENAME_EXCHANGE of Linux: two names swap what they stand for, in one step."""


def write_atomic(path: str | Path, data: str | bytes) -> None:
    """Write a temporary file next to ``path``, then rename it; text becomes UTF-8.

    A symbolic link stays one: what it points to is written.
    The bytes are on the disk before the name is, so that a loss of power leaves the old file or
    the new one.

    Raises
    ------
    UserError
        The folder cannot be written to; an older file of that name is unchanged.
    """
    path = Path(path)
    raw = data.encode("utf-8", "backslashreplace") if isinstance(data, str) else data
    try:
        if is_device(path):
            path.write_bytes(raw)
            return
        end = _end(path)
        part = part_of(end)
        try:
            part.write_bytes(raw)
            put(part, end)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(f"output {str(path)!r}: {reason(error)}; {_elsewhere(error)}") from None


def write_record(path: Path, record: object) -> None:
    """Write a record as one line of JSON, floats to six digits; errors as ``write_atomic``."""
    exact = json.dumps(record, default=float)
    short = json.loads(exact, parse_float=lambda text: float(f"{float(text):.6g}"))
    write_atomic(path, json.dumps(short, separators=(",", ":")) + "\n")


def read_bytes(path: Path) -> bytes:
    """What a file holds.

    Raises
    ------
    OSError
        It cannot be read, or holds more than ``MOST_BYTES``, as what never ends does.
    """
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise OSError(errno.EFBIG, f"more than {MOST_BYTES >> 20} MiB", str(path))
    return raw


def read_json(path: Path) -> Any:
    """What a JSON file holds.

    Raises
    ------
    OSError
        It cannot be read, or is too large.
    ValueError
        It is no JSON, or nested too deeply to be read.
    """
    try:
        return json.loads(read_bytes(path).decode("utf-8"))
    except RecursionError:
        raise ValueError("nested too deeply") from None


def decoded(raw: bytes) -> str:
    """Text of a table that some tool wrote: UTF-8, UTF-16 with its mark, or Latin-1."""
    wide = raw[:2] in (b"\xff\xfe", b"\xfe\xff")
    try:
        return raw.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def as_text(name: str) -> str:
    """Name of a file, for people; what is not UTF-8 in it as ``?``."""
    return name.encode("utf-8", "replace").decode("utf-8")


def is_device(path: Path) -> bool:
    """Whether something that is neither file nor folder has the name, such as /dev/null."""
    return path.exists() and not (path.is_file() or path.is_dir())


def part_of(path: Path) -> Path:
    """Name beside ``path`` to write to first; removes what killed processes left of the same."""
    sweep(path.parent, path.name)
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def put(part: Path, path: Path) -> None:
    """Let a finished file or folder take the place of another, whatever happens meanwhile.

    The folder that was there before has the name ``part`` then.

    Raises
    ------
    OSError
        It cannot be renamed, or the other one is write-protected: renaming alone would not mind.
    """
    _refuse_protected(path)
    for file in [part, *part.rglob("*")] if part.is_dir() else [part]:
        sync(file)
    if part.is_dir() and path.is_dir():
        _swap(part, path)
    else:
        os.replace(part, path)
    sync(path.parent)


def _refuse_protected(path: Path) -> None:
    if path.exists() and not os.access(path, os.W_OK):
        raise OSError(errno.EACCES, "it is write-protected")


def sync(path: Path) -> None:
    """Wait until a file or the names in a folder are on the disk, where the system can do that."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _swap(part: Path, path: Path) -> None:
    """Swap two folders, in one step where the system can; else one has no name for a moment."""
    here = -100  # AT_FDCWD
    try:
        rename = ctypes.CDLL(None).renameat2
        a, b = os.fsencode(part), os.fsencode(path)
        if rename(here, a, here, b, ctypes.c_uint(EXCHANGE)) == 0:
            return
    except (AttributeError, OSError, TypeError):
        pass
    old = path.with_name(f"{part.name}.old")
    os.rename(path, old)
    try:
        os.rename(part, path)
    except OSError:
        os.rename(old, path)
        raise
    os.rename(old, part)


def sweep(folder: Path, name: str | None = None) -> None:
    """Remove what killed processes left half-written in a folder, of one name or of all."""
    with suppress(OSError):
        for path in list(folder.iterdir()):
            found = PART.fullmatch(path.name)
            if found and name in (None, found[1]) and _abandoned(path, int(found[2])):
                remove(path)


def is_part(name: str) -> bool:
    """Whether a file of this name is half-written."""
    return PART.fullmatch(name) is not None


def _abandoned(path: Path, process: int) -> bool:
    """Whether the process that wrote it has ended; one of another computer counts for a while."""
    with suppress(OSError):
        return not _alive(process) and time.time() - path.stat().st_mtime > OLD
    return False


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that it holds."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def ensure_writable(folder: str | Path) -> Path:
    """Create a folder with its parents, make sure that files can be made in it, and return it.

    Raises
    ------
    UserError
        It cannot be created or written to.
    """
    folder = Path(folder)
    probe = folder / f".probe.{os.getpid()}.part"
    try:
        if any(len(os.fsencode(name)) > LONGEST for name in folder.parts):
            raise OSError(errno.ENAMETOOLONG, os.strerror(errno.ENAMETOOLONG))
        folder.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UserError(
            f"output folder {str(folder)!r}: {reason(error)}; give a folder that can be written to"
        ) from None
    return folder


def check_folder(folder: str | Path) -> None:
    """Check before a long run that a folder can be written to; one that is new is made later.

    Errors as in ``ensure_writable``.
    """
    folder = Path(folder)
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        ensure_writable(folder)
    finally:
        for path in new:
            with suppress(OSError):
                path.rmdir()


def check_writable(path: str | Path | None, name: str = "out", ending: str | None = None) -> None:
    """Check before a long run that a file can be written; None means no file.

    Raises
    ------
    UserError
        The folder does not exist or cannot be written to, the path is a folder, or its name does
        not end in ``ending``, that of what will be written; the message names the option ``name``.
    """
    if path is None:
        return
    path = Path(path)
    folder = path.parent
    try:
        if not folder.is_dir():
            raise UserError(
                f"{name}: {str(path)!r}: folder {str(folder)!r} does not exist; create it, or "
                "write to another one"
            )
        if path.is_dir():
            raise UserError(f"{name}: {str(path)!r} is a folder; give the name of a file")
        if is_device(path):
            return
        if ending is not None and path.suffix.lower() != ending:
            raise UserError(f"{name}: {str(path)!r}: give a name that ends in {ending}")
        _refuse_protected(path)
        probe = part_of(_end(path))
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UserError(f"{name}: {str(path)!r}: {reason(error)}; {_elsewhere(error)}") from None


def _end(path: Path) -> Path:
    """Where a path leads to, at the end of symbolic links."""
    return Path(os.path.realpath(path)) if path.is_symlink() else path


def _elsewhere(error: OSError) -> str:
    if error.errno == errno.ENAMETOOLONG:
        return f"give a name of at most {LONGEST - 24} bytes"  # with what ``part_of`` adds
    return "write to another folder"


def reason(error: Exception) -> str:
    """Why a file could not be read or written, in a few words."""
    return getattr(error, "strerror", None) or str(error)

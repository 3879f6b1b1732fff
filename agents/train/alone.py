"""Lets one training at a time into a run folder."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sensorless.errors import UserError

if sys.platform != "win32":
    import fcntl


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Hold a run folder; however a process ends, it holds none any more.

    The lock is on the folder itself and leaves no file. Windows, and file systems without locks,
    let everyone in.

    Raises
    ------
    UserError
        Another training holds it.
    """
    if sys.platform == "win32":
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise UserError(
                    f"run: {str(folder)!r} is in use by another training; wait until it has ended, "
                    "or give another folder"
                ) from None
        yield
    finally:
        os.close(handle)

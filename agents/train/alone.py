"""Lets one command at a time into a folder that it writes."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from sensorless.errors import UserError

if sys.platform != "win32":
    import fcntl


@contextmanager
def alone(folder: Path, option: str = "run", by: str = "training") -> Iterator[None]:
    """Hold a folder; however a process ends, it holds none any more.

    The lock is on the folder itself and leaves no file. Windows, and file systems without locks,
    let everyone in.

    Raises
    ------
    UserError
        Another command holds it; the message names the option and what it does.
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
                    f"{option}: {str(folder)!r} is in use by another {by}; wait until it has "
                    "ended, or give another folder"
                ) from None
        yield
    finally:
        os.close(handle)

"""Objects of the exported core, compiled once by every compiler with the same flags.

They stay in ``build/objects`` from one run of the tests to the next.
"""

import hashlib
import os
import re
import shutil
import subprocess
import tempfile
import time
from contextlib import suppress
from pathlib import Path

BUILD = Path(__file__).resolve().parents[2] / "build" / "objects"
UNUSED = 7 * 86400.0
"""Time after which objects that no run has used are removed [s]."""

Failed = subprocess.CompletedProcess
LINKING = {"-r", "-nostdlib", "-no-pie"}
"""Words of a command that say nothing about objects."""


def flags(makefile: Path, *names: str) -> list[str]:
    """Words of variables that a makefile sets, one after another."""
    text = makefile.read_text(encoding="utf-8")
    found = [re.findall(rf"^{name}\s*[:?]=(.*)", text, re.MULTILINE) for name in names]
    return [word for (line,) in found for word in line.split()]


def keep(made: Path, place: Path) -> None:
    """Copy a folder of objects to its place, at once; another run may do the same."""
    place.parent.mkdir(parents=True, exist_ok=True)
    part = Path(tempfile.mkdtemp(dir=place.parent))
    shutil.copytree(made, part, dirs_exist_ok=True)
    with suppress(OSError):
        part.rename(place)
    shutil.rmtree(part, ignore_errors=True)


def is_kept(place: Path) -> bool:
    """Whether objects are there; a place that is asked for stays."""
    with suppress(FileNotFoundError):
        os.utime(place)
        return True
    return False


def remove_unused() -> None:
    """Remove what no run has asked for of late."""
    for place in BUILD.glob("*"):
        with suppress(FileNotFoundError):  # another run may do the same
            if place.stat().st_mtime < time.time() - UNUSED:
                shutil.rmtree(place, ignore_errors=True)


def program_of(command: str) -> str:
    """A compiler and its version, as far as its file tells."""
    program = Path(shutil.which(command) or command).resolve()
    return f"{program} {program.stat().st_mtime_ns if program.exists() else 0}"


def place_of(core: Path, command: list[str], *more: Path) -> Path:
    """Where the objects of a folder ``core``, or of ``more``, are kept under a command.

    Warnings do not matter: ``make selftest`` compiles with all of them at every level.
    """
    levels = [word for word in command if word.startswith("-O")]
    others = {word for word in command[1:] if not word.startswith(("-O", "-W"))} - LINKING
    digest = hashlib.sha256(repr([program_of(command[0]), levels[-1:], sorted(others)]).encode())
    for path in [*sorted(core.glob("*.[ch]")), *more, *(p.with_suffix(".h") for p in more)]:
        digest.update(path.name.encode() + path.read_bytes())
    return BUILD / digest.hexdigest()


def compiled(core: Path, command: list[str], *more: Path) -> "list[Path] | Failed[str]":
    """Objects of all sources in ``core``, or how the compiler failed.

    Or of ``more``, sources that include headers of their own names and of the core.
    """
    place = place_of(core, command, *more)
    if not is_kept(place):
        words = [*command, "-c", *map(str, more or sorted(core.glob("*.c")))]
        with tempfile.TemporaryDirectory() as made:
            done = subprocess.run(words, cwd=made, capture_output=True, text=True, check=False)
            if done.returncode:
                return done
            keep(Path(made), place)
    return sorted(place.glob("*.o"))

"""Objects of the exported core, compiled once by every compiler with the same flags."""

import hashlib
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

Failed = subprocess.CompletedProcess
LINKING = {"-r", "-nostdlib", "-no-pie"}
"""Words of a command that say nothing about objects."""


def flags(makefile: Path, *names: str) -> list[str]:
    """Words of variables that a makefile sets, one after another."""
    text = makefile.read_text(encoding="utf-8")
    found = [re.findall(rf"^{name}\s*[:?]=(.*)", text, re.MULTILINE) for name in names]
    return [word for (line,) in found for word in line.split()]


@dataclass(frozen=True)
class Objects:
    """Objects in a folder, by the text of the sources, the compiler and its flags.

    Warnings are no such flag: ``make selftest`` compiles with all of them at every level.
    """

    folder: Path

    def place(self, core: Path, command: list[str], *more: Path) -> Path:
        """Where the objects of a folder ``core``, or of ``more``, are kept under a command."""
        program = Path(shutil.which(command[0]) or command[0]).resolve()
        levels = [word for word in command if word.startswith("-O")]
        others = {word for word in command[1:] if not word.startswith(("-O", "-W"))} - LINKING
        digest = hashlib.sha256(repr([program, levels[-1:], sorted(others)]).encode())
        for path in [*sorted(core.glob("*.[ch]")), *more, *(p.with_suffix(".h") for p in more)]:
            digest.update(path.name.encode() + path.read_bytes())
        return self.folder / digest.hexdigest()

    def of(self, core: Path, command: list[str], *more: Path) -> "list[Path] | Failed[str]":
        """Objects of all sources in ``core``, or how the compiler failed.

        Or of ``more``, sources that include headers of their own names and of the core.
        """
        place = self.place(core, command, *more)
        if not place.is_dir():
            place.mkdir()
            sources = map(str, more or sorted(core.glob("*.c")))
            done = subprocess.run(
                [*command, "-c", *sources], cwd=place, capture_output=True, text=True, check=False
            )
            if done.returncode:
                shutil.rmtree(place)
                return done
        return sorted(place.glob("*.o"))

    def keep(self, core: Path, command: list[str], made: Path) -> None:
        """Keep objects that ``make`` has made of ``core`` with this command."""
        shutil.copytree(made, self.place(core, command), dirs_exist_ok=True)

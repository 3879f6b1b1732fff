"""Compiles an exported folder with this computer's compiler and runs its self test."""

import os
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from sensorless.errors import UserError

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")


@dataclass(frozen=True)
class SelfTest:
    """Outcome of a self test that passed or could not run."""

    ran: bool
    message: str
    """One line."""


def find_compiler() -> list[str] | None:
    """Command of the C compiler: ``$CC``, else cc, gcc or clang; None without one."""
    named = shlex.split(os.environ.get("CC", ""))
    for command in (named, ["cc"], ["gcc"], ["clang"]):
        if command and shutil.which(command[0]):
            return command
    return None


def compile_program(
    compiler: list[str], sources: list[Path], program: Path
) -> subprocess.CompletedProcess[str]:
    """Compile and link sources, as an exported folder asks for it."""
    command = [*compiler, *FLAGS, "-o", str(program), *map(str, sources)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def run_selftest(folder: Path) -> SelfTest:
    """Build outside of ``folder`` and run.

    Raises
    ------
    UserError
        The code does not compile, or the self test finds a difference.
    """
    compiler = find_compiler()
    if compiler is None:
        return SelfTest(
            False,
            "self test not run, because there is no C compiler (cc, gcc, clang or $CC); "
            "run 'make selftest' in the folder on a computer that has one",
        )
    sources = [
        *sorted((folder / "test").glob("*.c")),
        *sorted(folder.glob("*.c")),
        *sorted((folder / "cmsis").glob("*.c")),
        *sorted((folder / "core").glob("*.c")),
    ]
    with tempfile.TemporaryDirectory() as build:
        program = Path(build) / "selftest"
        done = compile_program(compiler, sources, program)
        if done.returncode == 0:
            done = subprocess.run([program], capture_output=True, text=True, check=False)
    text = (done.stderr or done.stdout).strip().splitlines()
    if done.returncode != 0:
        line = next((s for s in text if "error" in s or "FAILED" in s), text[0] if text else "")
        raise UserError(
            f"self test with {shlex.join(compiler)}: {line or done.returncode}; use a "
            "compiler for plain IEEE 754 single precision (set CC)"
        )
    return SelfTest(True, done.stdout.strip())

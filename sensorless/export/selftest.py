"""Compiles an exported folder with this computer's compiler and runs its self test."""

import os
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from sensorless.errors import UserError
from sensorless.files import reason

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math")


@dataclass(frozen=True)
class SelfTest:
    """Outcome of a self test that passed or could not run."""

    ran: bool
    message: str
    """One line."""


def find_compiler() -> list[str] | None:
    """Command of the C compiler: ``$CC``, else cc, gcc or clang; None without one.

    Raises
    ------
    UserError
        ``$CC`` cannot be read as a command.
    """
    try:
        named = shlex.split(os.environ.get("CC", ""))
    except ValueError as error:
        raise UserError(f"CC: {os.environ['CC']!r}: {error}; set it to a C compiler") from None
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
            done = _run(program, compiler)
    if done.returncode != 0:
        why = _why(done)
        hint = "TMPDIR sets another folder" if "temporary" in why else "CC sets another"
        raise UserError(f"self test with {shlex.join(compiler)}: {why} ({hint})")
    return SelfTest(True, done.stdout.strip())


def _run(program: Path, compiler: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run([program], capture_output=True, text=True, check=False)
    except OSError as error:
        raise UserError(
            f"self test with {shlex.join(compiler)}: what it compiles to does not run here "
            f"({reason(error)}): set CC to this computer's own compiler, or TMPDIR to a folder "
            "from which programs may run"
        ) from None


def _why(done: subprocess.CompletedProcess[str]) -> str:
    """Line of the output that says most."""
    text = (done.stderr or done.stdout).strip().splitlines()
    for sign in ("FAILED", "undefined reference", "error", "temporary file"):
        for line in text:
            if sign in line:
                return line
    if done.returncode < 0:
        return f"stopped by signal {-done.returncode}"
    return text[0] if text else f"exit status {done.returncode}"

"""Cross compiler and emulator: checks for them and builds an exported folder with them."""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from sensorless.errors import UserError
from sensorless.export.core_files import FIRMWARE, core_files

CROSS = "arm-none-eabi-"
QEMU = "qemu-system-arm"
PACKAGES = {f"{CROSS}gcc": "gcc-arm-none-eabi", QEMU: "qemu-system-arm", "make": "make"}
"""Programs, each with its Debian package."""


def missing_packages() -> list[str]:
    """Debian packages of the programs that are not installed."""
    return [package for program, package in PACKAGES.items() if shutil.which(program) is None]


def require_tools() -> None:
    """Stop if cross compiler or emulator is missing.

    Raises
    ------
    UserError
        A program is missing; the message names the Debian packages.
    """
    missing = missing_packages()
    if missing:
        raise UserError(
            "pil: programs are missing; on Debian, run: apt-get install --no-install-recommends "
            f"{' '.join(missing)}"
        )


def build(exported: Path, folder: Path, what: str, level: str = "-O2", cc: str = "cc") -> Path:
    """Compile an exported folder with ``firmware/Makefile``.

    Parameters
    ----------
    exported : Path
        Folder that ``sensorless export`` wrote.
    folder : Path
        Folder for objects and the program.
    what : str
        ``image`` for the emulated target, ``host`` for a program on this computer.
    level, cc : str
        Optimisation level, and compiler of the host.

    Raises
    ------
    UserError
        The code does not compile; the message has the compiler's first error.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:  # names that make does not misread
        for name, target in (("export", exported), ("build", folder), ("firmware", FIRMWARE)):
            os.symlink(target.resolve(), f"{place}/{name}")
        command = ["make", "-s", "-f", "firmware/Makefile", "EXPORT=export", "BUILD=build",
                   f"OPT={level}", f"CC={cc}", what]  # fmt: skip
        done = subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
        line = next((s for s in lines if "error" in s), lines[0])
        raise UserError(f"pil: {what} at {level}: {line}; fix the code so that it compiles")
    return folder / ("image.elf" if what == "image" else "host")


def qemu_command(image: Path) -> list[str]:
    """Command that runs an image; one instruction takes 64 ns of its clock."""
    return [
        QEMU, "-M", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none",
        "-chardev", "stdio,id=console", "-semihosting-config",
        "enable=on,target=native,chardev=console", "-icount", "shift=6,sleep=off,align=off",
        "-kernel", str(image),
    ]  # fmt: skip


def _output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def versions() -> dict[str, str]:
    """First line of the versions of cross compiler and emulator."""
    return {name: _output(name, "--version").splitlines()[0] for name in (f"{CROSS}gcc", QEMU)}


def sections(path: Path) -> dict[str, int]:
    """Bytes of the sections that are loaded or reserved in an object or image."""
    found: dict[str, int] = {}
    for line in _output(f"{CROSS}size", "-A", str(path)).splitlines():
        match = re.match(r"\.(text|rodata|data|bss)\S*\s+(\d+)", line)
        if match:
            found[match[1]] = found.get(match[1], 0) + int(match[2])
    return found


def symbol_sizes(path: Path) -> dict[str, int]:
    """Bytes of every function and object in an object file."""
    rows = (line.split() for line in _output(f"{CROSS}nm", "-S", str(path)).splitlines())
    return {row[3]: int(row[1], 16) for row in rows if len(row) == 4}


def fused_instructions(image: Path) -> int:
    """Number of fused multiply-adds in an image; they would change the bits."""
    return len(re.findall(r"\tvf(?:n?m[as])\.", _output(f"{CROSS}objdump", "-d", str(image))))


def stack_of(folder: Path, functions: tuple[str, ...]) -> int:
    """Most stack of the functions with all that they call [byte], from GCC's call graphs."""
    text = "".join(path.read_text(encoding="utf-8") for path in folder.glob("*.ci"))
    node = r'node: \{ title: "([^"]+)" label: "[^"]*\\n(\d+) bytes'
    frames = {name: int(size) for name, size in re.findall(node, text)}
    calls: dict[str, set[str]] = {}
    for caller, called in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
        calls.setdefault(caller, set()).add(called)

    def depth(name: str) -> int:  # the core calls in no circle
        return frames.get(name, 0) + max(map(depth, calls.get(name, ())), default=0)

    return max(map(depth, functions))


def shipped(gains: bool) -> list[str]:
    """Objects of the control core without those that run in place of a drive, or once."""
    sources = (Path(name) for name in core_files(gains) if name.endswith(".c"))
    return [
        path.stem for path in sources if not re.search(r"_selftest$|^bring_up|_hook$", path.stem)
    ]


def memory(folder: Path) -> dict[str, dict[str, int]]:
    """Flash and static RAM [byte] of the parts of a product, from the objects of a build."""
    table = symbol_sizes(folder / "ks_table_data.o")
    q15 = symbol_sizes(folder / "ks_table_q15.o")
    code = symbol_sizes(folder / "ks_table.o")
    check = sum(size for name, size in code.items() if not re.match(r"eval_|ks_table_eval", name))
    return {
        **{
            f"{name}.o": sections(folder / f"{name}.o")
            for name in shipped((folder / "gain_table.o").exists())
        },
        "table_f32": {"rodata": table["ks_table_f32"] + table["ks_values_f32"]},
        "table_q15": {"rodata": q15["ks_table_q15"] + q15["ks_values_q15"]},
        "table_check": {"text": check},
        "image": sections(folder / "image.elf"),
    }

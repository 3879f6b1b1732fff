"""Compiles the unmodified C core, and ``page.c``, to WebAssembly.

Results have the bits of the native core: WebAssembly's float32 and float64 are those of IEEE 754
without fused operations, its square root is an instruction, and the core uses no other function.
"""

import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path

from sensorless.errors import UserError

WEB = Path(__file__).resolve().parent
ROOT = WEB.parent
BUILD = ROOT / "build" / "playground"
NEEDED = ("carrier", "flux_correction", "flux_map", "plant", "start", "trace")
"""What of the simulation the page runs: one drive, period by period."""
SOURCES = [
    *sorted((ROOT / "core" / "drive").glob("*.c")),
    *(ROOT / "core" / "sim" / f"{name}.c" for name in NEEDED),
    WEB / "page.c",
]
TOOLS = {"clang": "clang", "wasm-ld": "lld"}
"""Programs, and their Debian packages."""
EXPORTS = (
    "page_decide",
    "page_range",
    "sim_start",
    "sim_signals",
    "ks_table_check",
    "ks_header_crc",
    "ks_values_crc",
    "__heap_base",
)
COMMAND = (
    *("clang", "--target=wasm32", "-mbulk-memory", "-std=c99", "-O2", "-ffreestanding"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),
    "-DCORE_INLINE=static inline",  # half the size and time to compile, and no slower
    *("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", "-nostdlib"),
    *("-Wl,--no-entry", "-Wl,--gc-sections", "-Wl,--strip-all", "-Wl,-z,stack-size=65536"),
    *(f"-Wl,--export={name}" for name in EXPORTS),
    *(f"-I{ROOT / folder}" for folder in ("core", "core/drive", "build/generated")),
)


def missing_tools() -> list[str]:
    """Debian packages of the programs that are not installed."""
    return [package for program, package in TOOLS.items() if shutil.which(program) is None]


def compile_core() -> bytes:
    """Return the WebAssembly module; it is compiled only once for the same sources.

    Raises
    ------
    UserError
        A program is not installed, or the core does not compile.
    """
    if missing_tools():
        raise UserError(
            f"playground: needs {', '.join(missing_tools())}; run: apt-get install "
            + " ".join(missing_tools())
        )
    digest = hashlib.sha256(" ".join(COMMAND).encode())
    for path in [*SOURCES, *sorted((ROOT / "core").glob("*/*.h"))]:
        digest.update(path.read_bytes())
    out = BUILD / f"core-{digest.hexdigest()[:16]}.wasm"
    if not out.is_file():
        BUILD.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=BUILD) as folder:  # another process may compile too
            made = Path(folder, out.name)
            done = subprocess.run(
                [*COMMAND, *map(str, SOURCES), "-o", str(made)],
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode:
                raise UserError(f"playground: the core does not compile:\n{done.stderr}")
            made.replace(out)
    return out.read_bytes()

"""Build of the extension ``sensorless._core`` from the C core (cffi, API mode).

No declaration is written twice: the C preprocessor expands the headers, and every type, enumeration
and linkable function in them becomes part of the binding. A hash of all C sources is compiled in,
which shows whether a build is stale. ``sim_fields.h``, the list of all numbers in
``sim_t`` that the vector code of ``block.h`` works on, is generated from the same declarations.
"""

import os
import re
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cffi import FFI
from pycparser import c_ast, c_generator, c_parser

CORE = Path(__file__).resolve().parent
sys.path.insert(0, str(CORE))
from source_hash import FIRMWARE, WIRE, source_hash  # noqa: E402  (a build script has no package around it)

GENERATED = CORE.parent / "build" / "generated"
SOURCES = sorted(path.relative_to(CORE).as_posix() for path in CORE.glob("*/*.c"))
HEADERS = (
    "sim/sim_gains.h",
    "sim/simulate.h",
    "sim/start.h",
    "sim/trace.h",
    "sim/truth.h",
    "sim/edge_losses.h",
    "sim/carrier.h",
    "sim/commission.h",
    "sim/replay.h",
    "drive/gain_selftest.h",
    "sim/faulty.h",
    "sim/bring_up_run.h",
    "drive/ks_hook.h",
    "drive/ks_selftest.h",
    "pil_wire.h",
)
INCLUDE = (CORE, CORE / "drive", FIRMWARE)  # the wire format finds drive.h as on the target
CFLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
THREADS = [] if os.name == "nt" else ["-pthread"]
STDINT = (
    "typedef signed int int32_t; typedef unsigned int uint32_t;"
    "typedef short int16_t; typedef unsigned short uint16_t;"
)

IDLE = (
    "start.",
    "control.start.",
    *(f"twin.x.{part}." for part in ("emf", "smo", "flux", "coupled", "signal", "start", "lock")),
)
"""Paths in ``sim_t`` that a block neither reads nor writes: starts, and what a twin observes."""
LOCK = (
    "drive.x.lock.",
    "drive.x.control.u_sum.",
    "drive.x.control.i_sum.",
    "drive.x.control.i_d_end",
    "drive.x.control.i_q_least",
    "drive.x.coupled.gain_",
    "drive.x.fault",
)
"""Paths that the tests of lock.h change."""
LEAST_RUN = 4
"""Units that ``block_copy.h`` copies at a time."""


def _preprocessed() -> str:
    """The headers after the C preprocessor, without system headers and compiler extensions."""
    text = "".join(f'#include "{name}"\n' for name in HEADERS)
    compiler = os.environ.get("CC") or (sysconfig.get_config_var("CC") or "cc").split()[0]
    text = subprocess.run(
        [
            *compiler.split(),
            "-E",
            "-P",
            "-nostdinc",
            "-U__GNUC__",
            "-DCORE_SQRTF=sqrtf",
            *(f"-I{folder}" for folder in INCLUDE),
            f"-I{CORE}/cdef",
            "-",
        ],
        input=text,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    return STDINT + re.sub(r"__builtin_sqrtf?", "sqrt_builtin", text)


def declarations() -> str:
    """C declarations for cffi: all types and linkable functions, no function bodies."""
    tree = c_parser.CParser().parse(_preprocessed())
    keep = [
        node
        for node in tree.ext
        if not isinstance(node, c_ast.FuncDef)
        and not (isinstance(node, c_ast.Typedef) and node.name.startswith(("int", "uint")))
    ]
    return str(c_generator.CGenerator().visit(c_ast.FileAST(keep)))


def _macros() -> str:
    """Declarations of macros too large for some enumerations; the compiler fills in the values."""
    text = "".join(path.read_text(encoding="utf-8") for path in sorted(CORE.glob("drive/*.h")))
    names = re.findall(r"^#define (\w+) (?:0x\w+|\d+)UL\b", text, re.MULTILINE)
    return "".join(f"#define {name} ...\n" for name in names)


def _numbers(ctype: Any, path: str) -> Iterator[tuple[str, str]]:
    """Type and path of every number in a C type."""
    if ctype.kind == "struct":
        for name, field in ctype.fields:
            yield from _numbers(field.type, f"{path}.{name}" if path else name)
    elif ctype.kind == "array":
        for j in range(ctype.length):
            yield from _numbers(ctype.item, f"{path}[{j}]")
    else:
        yield ctype.cname, path


def _units(ffi: FFI) -> Iterator[list[str]]:
    """Paths of the one double or two numbers in each 8 bytes of ``sim_t``; padding is refused."""
    numbers = [(ffi.sizeof(x), path) for x, path in _numbers(ffi.typeof("sim_t"), "")]
    if sum(size for size, _ in numbers) != ffi.sizeof("sim_t"):
        raise ValueError("sim_t has padding: give its structs an even number of 4-byte fields")
    at = 0
    while at < len(numbers):
        count = 8 // numbers[at][0]
        yield [path for _, path in numbers[at : at + count]]
        at += count


def _runs(units: list[list[str]]) -> Iterator[tuple[int, int]]:
    """First unit and end of each run that a block uses; gaps and runs are ``LEAST_RUN`` or more."""
    used = [u for u, paths in enumerate(units) if not all(x.startswith(IDLE) for x in paths)]
    first = 0
    for at in range(1, len(used) + 1):
        if at == len(used) or used[at] - used[at - 1] > LEAST_RUN:
            if at - first < LEAST_RUN:
                raise ValueError("IDLE leaves a run of sim_t that is too short to copy")
            yield used[first], used[at - 1] + 1
            first = at


def write_fields(ffi: FFI) -> None:
    """Write ``sim_fields.h``: what stays constant of ``sim_t``, what moves, what lock.h changes.

    Blocks hold no drive in its start sequence (``batch_fits``), so that state is constant there.
    """
    moving = {"drive", "twin", "now", "sums", "tau_1", "dev_1", "err_count"}
    moving |= {"k", "lost", "begun", "k_lost"}
    lists: dict[str, list[str]] = {"PARAM": [], "STATE": [], "LOCK": []}
    for ctype, path in _numbers(ffi.typeof("sim_t"), ""):
        if path.startswith(IDLE):
            continue
        kind = "STATE" if path.split(".")[0] in moving and ".x.start." not in path else "PARAM"
        lists[kind].append(f"    X({ctype}, {path})")
        if path.startswith(LOCK):
            lists["LOCK"].append(f"    X({ctype}, {path})")
    text = "/* Generated by binding.py. */\n"
    for kind, lines in lists.items():
        text += f"#define SIM_{kind}_FIELDS(X) \\\n" + " \\\n".join(lines) + "\n"
    units = list(_units(ffi))
    flags = ", ".join(str(int(len(paths) == 2)) for paths in units)
    runs = ", ".join(f"{{{first}, {end}}}" for first, end in _runs(units))
    text += f"#define SIM_UNIT_IS_PAIR {{{flags}}}\n#define SIM_UNIT_RUNS {{{runs}}}\n"
    GENERATED.mkdir(parents=True, exist_ok=True)
    (GENERATED / "sim_fields.h").write_text(text)


def make_builder() -> FFI:
    """The cffi builder of ``sensorless._core``."""
    builder = FFI()
    builder.cdef(declarations() + _macros() + "extern const char core_hash[];\n")
    write_fields(builder)
    includes = "".join(f'#include "{name}"\n' for name in HEADERS)
    builder.set_source(
        "sensorless._core",
        f'{includes}\nconst char core_hash[] = "{source_hash()}";\n',
        sources=[os.path.relpath(CORE / name) for name in SOURCES],
        include_dirs=[*map(str, INCLUDE), str(GENERATED)],
        depends=[os.path.relpath(path) for path in [*sorted(CORE.glob("*/*.h")), WIRE]],
        extra_compile_args=CFLAGS + THREADS,
        extra_link_args=THREADS,
    )
    return builder


if __name__ == "__main__":
    make_builder().compile(tmpdir=str(CORE.parent), verbose=True)
else:
    ffibuilder = make_builder()

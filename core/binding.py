"""Builds the extension ``sensorless._core`` from the C core (cffi, API mode).

The declarations are not written twice: the C preprocessor expands ``simulate.h``, and every type,
enumeration and linkable function in it becomes part of the binding. A hash of all C sources is
compiled in, so that a stale build can be told from a fresh one.
"""

import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

from cffi import FFI
from pycparser import c_ast, c_generator, c_parser

CORE = Path(__file__).resolve().parent
sys.path.insert(0, str(CORE))
from source_hash import source_hash  # noqa: E402  (a build script has no package around it)

SOURCES = ("drive.c", "ks_table.c", "simulate.c")
HEADERS = ("simulate.h", "ks_table.h")
CFLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
STDINT = "typedef signed int int32_t; typedef unsigned int uint32_t;" \
         "typedef short int16_t; typedef unsigned short uint16_t;"


def _preprocessed() -> str:
    """The headers after the C preprocessor, without system headers and compiler extensions."""
    text = "".join(f'#include "{name}"\n' for name in HEADERS)
    compiler = os.environ.get("CC") or (sysconfig.get_config_var("CC") or "cc").split()[0]
    text = subprocess.run(
        [*compiler.split(), "-E", "-P", "-nostdinc", "-U__GNUC__", f"-I{CORE}", f"-I{CORE}/cdef", "-"],
        input=text, capture_output=True, text=True, check=True,
    ).stdout
    return STDINT + re.sub(r"__builtin_sqrtf?", "sqrt_builtin", text)


def declarations() -> str:
    """C declarations for cffi: all types and linkable functions, no function bodies."""
    tree = c_parser.CParser().parse(_preprocessed())
    keep = [
        node for node in tree.ext
        if not isinstance(node, c_ast.FuncDef)
        and not (isinstance(node, c_ast.Typedef) and node.name.startswith(("int", "uint")))
    ]
    return c_generator.CGenerator().visit(c_ast.FileAST(keep))


def make_builder() -> FFI:
    """The cffi builder of ``sensorless._core``."""
    builder = FFI()
    builder.cdef(declarations() + "\nextern const char core_hash[];\n")
    includes = "".join(f'#include "{name}"\n' for name in HEADERS)
    builder.set_source(
        "sensorless._core",
        f'{includes}\nconst char core_hash[] = "{source_hash()}";\n',
        sources=[os.path.relpath(CORE / name) for name in SOURCES],
        include_dirs=[str(CORE)],
        depends=[os.path.relpath(path) for path in sorted(CORE.glob("*.h"))],
        extra_compile_args=CFLAGS,
    )
    return builder


if __name__ == "__main__":
    make_builder().compile(tmpdir=str(CORE.parent), verbose=True)
else:
    ffibuilder = make_builder()

"""The C files depend on each other downwards only, and vector code has one rule."""

import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = (ROOT / "core" / "drive", ROOT / "core" / "sim", ROOT / "firmware")
PROGRAMS = {"port_m4": "port", "port_host": "port"}
"""Two ways to be one header's other half."""

Graph = dict[str, set[str]]


def code(path: Path) -> str:
    """Text without comments."""
    return re.sub(r"/\*.*?\*/", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def files() -> Iterator[Path]:
    for folder in FOLDERS:
        yield from sorted(folder.glob("*.[ch]"))


def unit(name: str) -> str:
    """A source and its header are one."""
    stem = Path(name).stem
    return PROGRAMS.get(stem, stem)


def includes() -> Graph:
    graph: Graph = {}
    for path in files():
        found = {unit(name) for name in re.findall(r'#include "([^"]+)"', code(path))}
        graph.setdefault(unit(path.name), set()).update(found - {unit(path.name)})
    return graph


def order(graph: Graph) -> list[str]:
    return list(TopologicalSorter(graph).static_order())


def test_no_circle_of_includes() -> None:
    found = order(includes())
    assert found.index("drive_types") < found.index("drive_start") < found.index("drive")
    assert found.index("drive") < found.index("sim") < found.index("simulate")


def test_what_ships_includes_nothing_else() -> None:
    drive = FOLDERS[0]
    shipped = {path.name for path in drive.iterdir()}
    for path in drive.glob("*.[ch]"):
        assert set(re.findall(r'#include [<"](.+)[>"]', code(path))) <= shipped | {"stdint.h"}
    assert "drive" in includes()["sim"], "what simulates does include what ships"


def test_a_circle_is_seen() -> None:
    graph = includes()
    graph["drive_start"].add("drive")
    with pytest.raises(CycleError):
        order(graph)


def declared(path: Path) -> set[str]:
    """Linkable functions that a header declares."""
    text = re.sub(r"__attribute__\(\(.*?\)\) ?", "", code(path))
    found = r"^(?!static|typedef|CORE_)\w[\w ]*[ *](\w+)\([^;{}]*\);"
    return set(re.findall(found, text, flags=re.MULTILINE))


def test_what_a_header_declares_its_own_source_defines() -> None:
    """So a call goes where the include goes: no circle of calls beside that of includes."""
    sources: dict[str, str] = {}
    for path in files():
        if path.suffix == ".c":
            sources[unit(path.name)] = sources.get(unit(path.name), "") + code(path)
    seen = set()
    for path in files():
        for name in declared(path) if path.suffix == ".h" else ():
            defined = rf"\b{name}\([^;{{}}]*\)\s*{{|#define BLOCK_RUN {name}\b"
            assert re.search(defined, sources.get(unit(path.name), "")), (path.name, name)
            seen.add(name)
    assert {"drive_step", "drive_seek", "sim_run", "sim_truth", "block_avx2", "pil_stages"} <= seen


def test_only_one_file_knows_of_vector_code() -> None:
    """All else says SCALAR_ONLY; vectorise.h, for the sources of vector code, defines the word."""
    knows = {path.name for path in files() if "CORE_VECTOR" in code(path)}
    assert knows == {"vector.h", "vectorise.h"}


def test_what_only_scalar_code_does_is_known() -> None:
    """Each has its case in test_batch.py: a drive of that kind is not in a block."""
    found = [
        condition
        for path in files()
        for condition in re.findall(r"if \(SCALAR_ONLY\((.*?)\)\) {", code(path))
    ]
    fields = {condition.split()[0].replace("->", ".").split(".")[-1] for condition in found}
    assert fields == {"phase", "scheme", "switching", "inv_stick", "carrier", "wait"}

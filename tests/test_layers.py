"""A layer is a folder: files import from lower ones and from their own, never in circles."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOP = ("agents", "baselines", "core", "envs", "observers")
"""Folders of the package that stand at the top; ``sensorless`` links to them."""

LAYERS = (
    ("errors", "files", "matlab_file", "plain_json", "plain_table", "settings", "units"),
    ("recording",),
    ("core",),
    ("machine", "table", "versions"),
    ("observers",),
    ("design",),
    ("decision", "policy", "suitability"),
    ("envs",),
    ("evaluation",),
    ("agents", "baselines"),
    ("policies",),
    ("falsify", "tuning"),
    ("export", "identify", "pil", "plant", "replay"),
    ("plots",),
    ("report", "reproduce"),
    ("cli",),
)
"""Folders and single files of ``sensorless``, lowest first."""

SIBLINGS = {
    ("files", "errors"),
    ("matlab_file", "files"),
    ("settings", "errors"),
    ("pil", "export"),
}
"""Who may import whom inside a layer."""

ABOVE_ALL = ("__init__", "__main__")
"""``__init__`` only registers the environments by name."""


def files() -> dict[str, Path]:
    """Python files of the package by module name, each once: links are not followed."""
    found = {}
    for folder in ("sensorless", *TOP):
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            parts = parts if parts[0] == "sensorless" else ("sensorless", *parts)
            found[".".join(parts).removesuffix(".__init__")] = path
    return found


FILES = files()


def room(module: str) -> str:
    """Folder or single file below ``sensorless`` that a module belongs to."""
    return [*module.split("."), "__init__"][1]


def layer(module: str) -> int:
    """Layer of a module, 0 is the lowest."""
    if room(module) in ABOVE_ALL:
        return len(LAYERS)
    found = [i for i, names in enumerate(LAYERS) if room(module) in names]
    if not found:
        raise LookupError(f"{module} is in no layer: add its folder to LAYERS in tests/test_layers")
    return found[0]


@cache
def parsed(source: str) -> list[ast.AST]:
    """All nodes of a source, which several tests look at."""
    return list(ast.walk(ast.parse(source)))


def imports(source: str) -> Iterator[tuple[int, str, str]]:
    """Line, module and name of every import of ``sensorless``, also inside functions."""
    for node in parsed(source):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.split(".")[0] == "sensorless":
                    yield node.lineno, alias.name, ""
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ValueError(f"line {node.lineno}: relative import: spell it from sensorless")
            if node.module and node.module.split(".")[0] == "sensorless":
                for alias in node.names:
                    whole = f"{node.module}.{alias.name}"
                    is_module = whole in FILES
                    yield node.lineno, whole if is_module else node.module, alias.name


def forbidden(module: str, source: str) -> list[str]:
    """Imports that climb, cross to a sibling that is not listed, or take a private name."""
    out = []
    for line, target, name in imports(source):
        if name == "_core" or target == "sensorless":  # the compiled core; __version__
            continue
        crossing = room(module) != room(target) and layer(module) == layer(target)
        if layer(target) > layer(module):
            out.append(f"line {line}: {module} imports {target} from a layer above")
        elif crossing and (room(module), room(target)) not in SIBLINGS:
            out.append(f"line {line}: {module} imports its sibling {target}")
        elif name.startswith("_"):
            out.append(f"line {line}: {module} imports the private name {target}.{name}")
    return out


def test_imports_point_down() -> None:
    found = [forbidden(name, path.read_text(encoding="utf-8")) for name, path in FILES.items()]
    assert len(found) > 300 and not any(found), [lines for lines in found if lines]


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("sensorless.design.drive", "from sensorless.envs.scenarios.scenario import Scenarios"),
        ("sensorless.machine.motor", "def late():\n    import sensorless.cli.app"),
        ("sensorless.envs.reward", "from sensorless.evaluation import rollout"),
        ("sensorless.agents.loading", "from sensorless.baselines.linear import EQ25"),
        ("sensorless.plots.envelope", "from sensorless.plots.figure import _figure"),
    ],
    ids=["a layer above", "inside a function", "a module", "a sibling", "a private name"],
)
def test_a_forbidden_import_is_found(module: str, source: str) -> None:
    """Added to the real file, which is clean without it."""
    text = FILES[module].read_text(encoding="utf-8")
    assert len(forbidden(module, f"{text}\n{source}\n")) == 1


def called(node: ast.expr) -> str:
    """Name that an expression ends with, if it is one."""
    return node.id if isinstance(node, ast.Name) else getattr(node, "attr", "")


def private_names(source: str) -> set[str]:
    """Private functions, classes, variables and attributes that a file defines."""
    found = set()
    for node in parsed(source):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            if node.value.id == "self":
                found.add(node.attr)
    return {name for name in found if re.fullmatch("_[^_].*", name)}


PRIVATE = set().union(*(private_names(p.read_text(encoding="utf-8")) for p in FILES.values()))


def pried(source: str) -> list[str]:
    """Private names of the package that a file outside of it imports, reads or replaces."""
    out: list[str] = []
    named = PRIVATE & set(re.findall(r"(?<!\w)_[^_\W]\w*", source))  # in most files none
    others = named - private_names(source) if named else named
    if not others:
        return out
    for node in parsed(source):
        names: list[object] = []
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sensorless."):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.Attribute) and (
            not isinstance(node.value, ast.Name) or node.value.id not in ("self", "cls")
        ):
            names = [node.attr]
        elif isinstance(node, ast.Call) and called(node.func).endswith("setattr"):
            names = [arg.value for arg in node.args[1:2] if isinstance(arg, ast.Constant)]
        out += [f"{ast.unparse(node)}: {name}" for name in names if name in others]
    return out


@pytest.mark.parametrize("folder", ["tests", "benchmarks", "studies", "web"])
def test_nobody_pries(folder: str) -> None:
    for path in (ROOT / folder).rglob("*.py"):
        assert not pried(path.read_text(encoding="utf-8")), path


@pytest.mark.parametrize(
    "source",
    [
        "from sensorless.tuning.tune import _judge",
        "from sensorless.tuning import tune as t\nt._judge",
        "factory._motor_of",
        "monkeypatch.setattr(tuning, '_judge', stop)",
    ],
)
def test_prying_is_found(source: str) -> None:
    assert len(pried(source)) == 1


def circle(graph: dict[str, set[str]]) -> list[str]:
    """One circle of a graph; none: empty."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_import_runs_in_a_circle() -> None:
    graph = {
        module: {t for _, t, _ in imports(path.read_text(encoding="utf-8")) if t in FILES}
        - {module, "sensorless"}
        for module, path in FILES.items()
    }
    assert not circle(graph)
    assert circle({**graph, "sensorless.errors": {"sensorless.cli.app"}})

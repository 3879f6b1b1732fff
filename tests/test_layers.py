"""A file imports only from its own layer or from a lower one."""

import ast
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("core", "observers", "envs", "baselines", "agents", "firmware", "sensorless")

# Lowest first. A pattern stands for sensorless.NAME and all below it; "" is sensorless/__init__.py.
LAYERS = (
    ("", "core", "core_*", "errors", "files", "motor", "magnetics", "ks_*"),
    ("observers", "*_design"),
    ("drive",),
    ("envs",),
    ("rollout", "*metrics", "objective", "suites", "steady"),
    ("baselines", "agents"),
    ("aggregate", "results*", "evaluate", "engine*", "tuning*"),
    ("export*", "pil*", "plant_*", "trace*", "plots", "options", "identify*", "rep*"),
    ("demo", "cli*", "__main__"),
)


def files() -> list[Path]:
    """Python files of the package, each once: links are not followed."""
    return sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))


def unit(module: str) -> str:
    """Name in the table of layers: the first part below ``sensorless``."""
    return [*module.split("."), ""][1]


def level(module: str) -> int | None:
    """Layer of a module, 0 is the lowest; None if no pattern matches."""
    name = unit(module)
    found = (i for i, layer in enumerate(LAYERS) if any(fnmatchcase(name, p) for p in layer))
    return next(found, None)


def module_of(path: Path) -> str:
    """Dotted import name of a file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    parts = parts[:-1] if parts[-1] == "__init__" else parts
    return ".".join(parts if parts[0] == "sensorless" else ("sensorless", *parts))


def imports(source: str) -> Iterator[tuple[int, str]]:
    """Line and dotted name of every import of ``sensorless``, also inside of functions."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level:
            raise ValueError(f"line {node.lineno}: relative import, write it out from sensorless")
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        yield from ((node.lineno, name) for name in names if name.split(".")[0] == "sensorless")


def upward(module: str, source: str) -> list[str]:
    """Imports in the source of a module that climb.

    A name without a layer is no Python file (``__version__``, the compiled ``_core``): it passes.
    """
    here = level(module) or 0
    return [
        f"line {line}: {unit(module)} (layer {here}) imports {name} (layer {level(name)})"
        for line, name in imports(source)
        if (level(name) or 0) > here
    ]


@pytest.mark.parametrize("path", files(), ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_down(path: Path) -> None:
    module = module_of(path)
    assert level(module) is not None, f"{path.name} is in no layer: add it to LAYERS in {__file__}"
    assert not upward(module, path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("module", "source", "climbs"),
    [
        (
            "sensorless.design.drive",
            "from sensorless.envs.scenarios.scenario import Scenario",
            True,
        ),
        ("sensorless.machine.motor", "def late():\n    import sensorless.cli.app", True),
        ("sensorless.envs.reward", "from sensorless import metrics", True),
        ("sensorless", "from sensorless.design.drive import Drive", True),
        ("sensorless.envs.blend_env", "from sensorless.envs.signals import SIGNALS", False),
        ("sensorless.cli.app", "import numpy\nfrom sensorless import __version__, agents", False),
    ],
)
def test_the_check_can_fail(module: str, source: str, climbs: bool) -> None:
    assert bool(upward(module, source)) == climbs

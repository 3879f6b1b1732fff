"""A file imports only from its own layer or from a lower one."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("core", "observers", "envs", "baselines", "agents", "firmware", "sensorless")

# Lowest first. A name stands for sensorless.NAME and all below it; "" is sensorless/__init__.py.
LAYERS = (
    ("", "core", "core_api", "errors", "motor", "magnetics", "ks_table"),
    ("observers", "control_design", "blend_design"),
    ("drive",),
    ("envs",),
    ("baselines", "agents"),
    ("metrics", "suites", "evaluate", "report"),
    ("export", "cli", "__main__"),
)
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def files() -> list[Path]:
    """Python files of the package, each once: links are not followed."""
    return sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))


def unit(module: str) -> str:
    """Name in the table of layers: the first part below ``sensorless``."""
    return [*module.split("."), ""][1]


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
    """Imports in the source of a module that climb, or whose layer is unknown.

    ``from sensorless import __version__`` imports no module: an unknown name there counts as "".
    """
    here = LEVEL[unit(module)]
    return [
        f"line {line}: {unit(module)} (layer {here}) imports {name} (layer {level})"
        for line, name in imports(source)
        if (level := LEVEL.get(unit(name), 0)) > here
    ]


@pytest.mark.parametrize("path", files(), ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_down(path: Path) -> None:
    module = module_of(path)
    assert unit(module) in LEVEL, f"{path.name}: in no layer, add it to LAYERS in {__file__}"
    assert not upward(module, path.read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("module", "source", "climbs"),
    [
        ("sensorless.drive", "from sensorless.envs.scenario import Scenario", True),
        ("sensorless.motor", "def late():\n    import sensorless.cli", True),
        ("sensorless.envs.reward", "from sensorless import metrics", True),
        ("sensorless", "from sensorless.drive import Drive", True),
        ("sensorless.envs.blend_env", "from sensorless.envs.signals import SIGNALS", False),
        ("sensorless.cli", "import numpy\nfrom sensorless import __version__, agents", False),
    ],
)
def test_the_check_can_fail(module: str, source: str, climbs: bool) -> None:
    assert bool(upward(module, source)) == climbs

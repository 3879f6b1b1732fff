"""Notebooks as Markdown for the site: every cell runs in this process, and its output is shown.

What a cell prints stands below it as text, and a figure that its last line gives as a picture.
Lines that begin with % are for Jupyter alone.
"""

import ast
import base64
import contextlib
import hashlib
import io
import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sensorless.plots.figure import png
from sensorless.versions import versions

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "notebooks"
SIZES = ("SCENARIOS", "STEPS")
"""Environment variables that notebooks take their sizes from."""
KEPT = ROOT / "build" / "notebooks"
PAGES = {f"{path.stem.replace('_', '-')}-hour.md": path for path in sorted(FOLDER.glob("*.ipynb"))}
"""Place on the site of every notebook."""


def cells(path: Path) -> Iterator[tuple[bool, str]]:
    """Whether a cell is code, and its text, in order."""
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        yield cell["cell_type"] == "code", "".join(cell["source"])


def run(text: str, names: dict[str, Any]) -> tuple[str, Any]:
    """Run a cell among the names of those before: what it printed, the value of its last line."""
    tree = ast.parse("\n".join(line for line in text.splitlines() if not line.startswith("%")))
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), names)
        value = None
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    return printed.getvalue(), value


@contextlib.contextmanager
def _inside(folder: str) -> Iterator[None]:
    """Work in a folder for a while."""
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def page(path: Path) -> str:
    """Page of a notebook; kept in ``build/notebooks`` until notebook, sizes or core change."""
    key = path.read_bytes() + Path(__file__).read_bytes() + versions()["core"].encode()
    key += repr([os.environ.get(name) for name in SIZES]).encode()
    kept = KEPT / f"{path.stem}-{hashlib.sha256(key).hexdigest()[:16]}.md"
    if not kept.is_file():
        KEPT.mkdir(parents=True, exist_ok=True)
        kept.write_text(markdown(path), encoding="utf-8")
    return kept.read_text(encoding="utf-8")


def markdown(path: Path) -> str:
    """Run a notebook in an empty folder and return it as a page, outputs included."""
    names: dict[str, Any] = {"__name__": "__main__"}
    parts = []
    with tempfile.TemporaryDirectory() as folder, _inside(folder):
        for is_code, text in cells(path):
            if not is_code:
                parts.append(text)
                continue
            printed, value = run(text, names)
            parts.append(f"```python\n{text}\n```")
            if printed.strip():
                parts.append(f"```text\n{printed.rstrip()}\n```")
            if hasattr(value, "savefig"):
                data = base64.b64encode(png(value)).decode()
                parts.append(f"![Output of the cell above](data:image/png;base64,{data})")
            elif value is not None:
                parts.append(f"```text\n{value!r}\n```")
    note = (
        f"*This page is `notebooks/{path.name}`, run when the site was built; "
        "open it with `jupyter lab` to change it.*"
    )
    return "\n\n".join([*parts[:1], note, *parts[1:]]) + "\n"

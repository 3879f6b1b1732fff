"""Makes HTML pages that need no other file and no network."""

import json
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

PARTS = Path(__file__).parent / "page"
UPLOT = "1.6.32"
"""Version of the files in ``page/uplot``."""
SCRIPTS = ("uplot/uPlot.iife.min.js", "sort.js", "map.js", "plot.js")


@cache
def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(PARTS),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["unbroken"] = lambda text: str(text).replace(" %", "\u00a0%")
    return made


def render(template: str, data: dict[str, Any] | None = None, **values: Any) -> str:
    """Text of a page.

    Parameters
    ----------
    template : str
        File in ``page/``.
    data : dict, optional
        What the script draws, in JSON types; without it the page has no script.
    **values
        What the template says.
    """
    style = "".join(_part(name) for name in ("uplot/uPlot.min.css", "style.css"))
    script = ""
    if data is not None:
        text = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
        code = "\n".join(_part(name) for name in SCRIPTS)
        script = f"<script>\nconst data = {text};\n{code}</script>\n"
    return (
        _environment()
        .get_template(template)
        .render(style=Markup(style), script=Markup(script), **values)
    )


def _part(name: str) -> str:
    return (PARTS / name).read_text(encoding="utf-8")

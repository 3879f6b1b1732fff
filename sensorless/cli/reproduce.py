"""The command ``sensorless reproduce``."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

console = Console()


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder for page, data and pictures.")] = Path(
        "results"
    ),
) -> None:
    """Run the source paper's figures and claims: the paper, ours as published, ours corrected.

    Figs. 4, 9, 11, 12, 13/14 and the abstract's numbers, on one page (paper.md) with pictures, and
    as data (paper.json). Takes seconds.
    """
    from sensorless.files import ensure_writable
    from sensorless.reproduce.reproduce import reproduce as run

    ensure_writable(out)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("reproduce", total=1.0)
        files = run(out, lambda done: bar.update(task, completed=done))
    for path in files:
        console.print(f"wrote {path}")

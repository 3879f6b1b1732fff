"""The command ``sensorless reproduce``."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from sensorless.cli.options import JsonOption, errors, say_wrote


def reproduce_command(
    out: Annotated[
        Path,
        typer.Option(metavar="FOLDER", help="Write page, data and pictures to this folder."),
    ] = Path("paper"),
    as_json: JsonOption = False,
) -> None:
    """Rerun the experiments of the source paper and set our figures beside the printed ones.

    One page (paper.md), with the same numbers as data (paper.json), gives for Figs. 4, 9, 11, 12,
    13/14 and the abstract what the paper prints, what our drive does as published, and what it
    does with the corrections. The pictures show our two drives, and the paper's values as lines.
    Takes seconds.

    For example:

        sensorless reproduce
    """
    from sensorless.files import check_folder
    from sensorless.reproduce.reproduce import DATA
    from sensorless.reproduce.reproduce import reproduce as run

    check_folder(out)
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=errors, transient=True) as bar:
        task = bar.add_task("reproduce", total=1.0)
        files = run(out, lambda done: bar.update(task, completed=done))
    if as_json:
        typer.echo((out / DATA).read_text(encoding="utf-8"), nl=False)
    say_wrote(*files)

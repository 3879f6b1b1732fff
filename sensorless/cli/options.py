"""Options and progress bars that several commands share."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

console = Console()
errors = Console(stderr=True)

MotorOption = Annotated[str, typer.Option("--motor", help="Shipped motor by name, or a TOML file.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Drive design, e.g. smo_pll_hz=30; repeatable."
    ),
]

EngineOption = Annotated[
    str, typer.Option(help="local: this process; ray: a cluster, see --ray-address.")
]
RayAddressOption = Annotated[
    str | None,
    typer.Option(
        help="HOST:PORT of a running Ray cluster; default: one of this machine's processors."
    ),
]


@contextmanager
def policy_progress() -> Iterator[Callable[[str, float], None]]:
    """Progress of several policies: bars on a terminal, else a line when one is done."""
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        TimeElapsedColumn(),
        console=errors,
        disable=not errors.is_terminal,
    )
    tasks: dict[str, TaskID] = {}

    def report(name: str, done: float) -> None:
        if name not in tasks:
            tasks[name] = bar.add_task(name, total=1.0)
        bar.update(tasks[name], completed=done)
        if done >= 1.0 and not errors.is_terminal:
            errors.print(f"evaluated {name}", markup=False, highlight=False)

    with bar:
        yield report

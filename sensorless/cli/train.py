"""The command ``sensorless train``: every field of ``TrainConfig`` is an option."""

import ast
import dataclasses
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from sensorless.agents.train.config import TrainConfig
from sensorless.errors import UserError

console = Console()
errors = Console(stderr=True)

RUNS = Path("runs")


def field_docs(cls: type) -> dict[str, str]:
    """Text under each field of a dataclass, as written in its source."""
    tree = ast.parse(inspect.getsource(cls)).body[0]
    docs, name = {}, None
    for node in tree.body if isinstance(tree, ast.ClassDef) else []:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name = node.target.id
        elif name and isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            docs[name], name = str(node.value.value), None
    return docs


def with_options(cls: type, function: Callable[..., None]) -> Callable[..., None]:
    """``function`` with one keyword option for every field of a dataclass behind its own."""
    docs = field_docs(cls)
    own = inspect.signature(function)
    fixed = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
    extra = [
        inspect.Parameter(
            f.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=f.default,
            annotation=Annotated[f.type, typer.Option(help=docs[f.name])],
        )
        for f in dataclasses.fields(cls)
    ]
    function.__signature__ = inspect.Signature([*fixed, *extra])  # type: ignore[attr-defined]
    function.__annotations__ = {p.name: p.annotation for p in [*fixed, *extra]}
    return function


def _train(
    *,
    name: Annotated[str | None, typer.Option(help="Run folder below runs/.")] = None,
    resume: Annotated[Path | None, typer.Option(help="Go on with the run in this folder.")] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Drive design, e.g. smo_pll_hz=30."),
    ] = None,
    **fields: Any,
) -> None:
    """Train a schedule with PPO; the table is the policy, and starts as a copy of Eq. 25.

    The run folder gets config.json (settings, command, versions, seed), start.json, the best
    schedule found in validation (table.json, or mlp.npz with --policy-kind mlp; the folder is
    usable as --policy), checkpoints, progress.csv and TensorBoard logs below tb/. The same --seed
    and --steps give the same schedule to the bit on the same machine; --minutes does not. Ctrl-C
    keeps a checkpoint; go on with --resume FOLDER (--minutes and --steps then count from there; not
    bit-identical to a run never interrupted).

        sensorless tune linear --out linear.json

        sensorless train --name better --start linear.json --axes speed:16 --steps 4000000
    """
    from sensorless.design.words import design_from

    if (name is None) == (resume is None):
        raise UserError("name, resume: allowed: exactly one, --name NEW or --resume FOLDER")
    folder = resume if resume is not None else RUNS / str(name)
    run_training(TrainConfig(**fields), design_from(settings), folder, resume=resume is not None)


def run_training(config: TrainConfig, design: Any, folder: Path, *, resume: bool) -> None:
    """Train with progress on the terminal, and say where the result is."""
    from sensorless.agents.train import train as training
    from sensorless.evaluation.objective import Cost
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import table_named

    columns = [TextColumn("training"), BarColumn(), TextColumn("{task.percentage:.0f} %")]
    columns += [TimeElapsedColumn(), TimeRemainingColumn(), TextColumn("{task.description}")]
    quiet = not errors.is_terminal
    bar = Progress(*columns, console=errors, disable=quiet)
    task = bar.add_task("", total=1.0)

    def report(done: float, steps: int, found: Cost | None) -> None:
        bar.update(task, completed=done, description=f"{steps / 1e6:.2f} M decisions")
        if found is not None:
            (errors if quiet else bar.console).print(
                f"{100 * done:3.0f} %, {steps / 1e6:5.2f} M decisions, validation: lost "
                f"{100 * found.lost_rate:.1f} %, torque deviation {100 * found.torque_dev:.2f} %, "
                f"ripple {100 * found.torque_ripple:.2f} %",
                highlight=False,
            )

    try:
        with bar:
            if resume:
                training.resume(config, folder, report=report)
            else:
                source = table_named(config.start, Motor.load(config.motor))
                training.train(config, design, folder, source, report=report)
    except KeyboardInterrupt:
        errors.print(f"interrupted; go on with: sensorless train --resume {folder}")
        raise typer.Exit(130) from None
    console.print(f"best schedule: {folder}")


train_command = with_options(TrainConfig, _train)

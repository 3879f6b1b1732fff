"""The command ``sensorless tune``."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from sensorless.cli.options import EngineOption, RayAddressOption, console, errors

if TYPE_CHECKING:
    from sensorless.evaluation.objective import Cost


def tune_command(
    name: Annotated[str, typer.Argument(help="Rule with parameters, see evaluate --list.")],
    out: Annotated[Path, typer.Option(help="JSON file to write.")],
    budget: Annotated[float, typer.Option(help="Time that may be simulated [s].")] = 20000.0,
    seed: Annotated[int, typer.Option(min=0, help="Draws scenarios and search.")] = 1,
    motor: Annotated[str, typer.Option(help="Shipped motor by name, or a TOML file.")] = "paper",
    machines: Annotated[
        int,
        typer.Option(min=0, help="Tune over so many random machines of the seed instead; 0: none."),
    ] = 0,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Drive design, e.g. smo_pll_hz=30."),
    ] = None,
    engine: EngineOption = "local",
    ray_address: RayAddressOption = None,
) -> None:
    """Tune the parameters of a hand-over rule by CMA-ES.

    Makes 10 lost_rate + torque deviation + torque ripple least, on stress scenarios that training
    and judging never see. The same words give the same file, on any engine. Ctrl-C keeps the best
    found so far.

        sensorless tune linear --budget 20000 --out linear-tuned.json

        sensorless evaluate --policy eq25 --policy linear-tuned.json
    """
    from sensorless.design.words import design_from
    from sensorless.evaluation.engines.named import engine_named
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.tuning.tune import tune

    check_writable(out)
    machine, design = Motor.load(motor), design_from(settings)
    columns = [TextColumn(f"tuning {name}"), BarColumn(), TextColumn("{task.percentage:.0f} %")]
    columns += [TimeElapsedColumn(), TimeRemainingColumn(), TextColumn("{task.description}")]
    bar = Progress(*columns, console=errors, disable=not errors.is_terminal)
    task = bar.add_task("", total=1.0)

    def report(done: float, best: "Cost", start: "Cost") -> None:
        bar.update(task, completed=done, description=f"best: {_words(best)}")

    with engine_named(engine, ray_address) as where, bar:
        found = tune(
            name,
            machine,
            design,
            budget,
            seed,
            machines=machines,
            command=shlex.join(["sensorless", *sys.argv[1:]]),
            progress=report,
            engine=where,
        )
    found.save(out)
    known = found.provenance
    for label in ("start", "best"):
        console.print(f"{label:5}: {_words_of(known[label])}", highlight=False)
    console.print(f"policy: {known['policy']}\nwrote {out}", highlight=False, soft_wrap=True)
    if known["interrupted"]:
        errors.print(f"interrupted after {known['used_s']:g} s of {budget:g} s simulated")
        raise typer.Exit(130)


def _words(found: "Cost") -> str:
    return _words_of(vars(found))


def _words_of(scores: dict[str, float]) -> str:
    return (
        f"lost {100 * scores['lost_rate']:.1f} %, torque deviation "
        f"{100 * scores['torque_dev']:.2f} %, ripple {100 * scores['torque_ripple']:.2f} %"
    )

"""The command ``sensorless pil``."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from sensorless.errors import UserError

console = Console()
errors = Console(stderr=True)


def pil_command(
    run: Annotated[
        str,
        typer.Argument(
            help="Folder of a training run, or a rule with a table: eq25, linear:LO,HI, constant:K."
        ),
    ],
    out: Annotated[Path | None, typer.Option(help="Report as JSON.")] = None,
    motor: Annotated[str, typer.Option(help="Shipped motor by name, or a TOML file.")] = "paper",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Drive design; repeatable."),
    ] = None,
) -> None:
    """Run the exported control core on an emulated Cortex-M4F, in the loop with the machine.

    Every word of every period is compared with the host; status 2 if one differs. Reports the
    instructions of a control period and of a lookup, flash and RAM. Needs arm-none-eabi-gcc and
    qemu-system-arm.
    """
    from sensorless.design.words import design_from
    from sensorless.export.export import table_of
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.pil.pil import passed, pil
    from sensorless.pil.report import table, write_report
    from sensorless.policies.registry import make_policy
    from sensorless.policy import design_for

    check_writable(out)
    machine = Motor.load(motor)
    policy = make_policy(run, machine)
    schedule, design = table_of(policy, run), design_for(policy, design_from(settings))
    columns = (TextColumn("closed loop on the target"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=errors, disable=not errors.is_terminal) as bar:
        task = bar.add_task("", total=1.0)
        report = pil(
            schedule,
            machine,
            design,
            policy=policy.name,
            progress=lambda done: bar.update(task, completed=done),
        )
    console.print(table(report))
    if out is not None:
        write_report(report, out)
        console.print(f"wrote {out}")
    if not passed(report):
        raise UserError("pil: host and target differ; allowed: no difference")

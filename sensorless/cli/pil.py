"""The command ``sensorless pil``."""

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from sensorless.cli.export import ScheduleArgument
from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    SetOption,
    bench_of,
    console,
    errors,
    minutely,
    say_json,
    say_wrote,
)
from sensorless.errors import UserError


def pil_command(
    run: ScheduleArgument,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Write the report as JSON. Default: no file."),
    ] = None,
    motor: CarriedMotorOption = None,
    settings: SetOption = None,
    override: OverrideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Run the exported C code on an emulated Cortex-M4F, in a closed loop with the machine.

    Processor in the loop: every word of every PWM period is compared with this computer, and one
    difference is an error (exit status 2). Reports the instructions of a control period and of a
    table lookup, and the flash and RAM they take. Needs arm-none-eabi-gcc and qemu-system-arm.

    For example:

        sensorless pil eq25 --out pil.json
    """
    from sensorless.export.export import table_of
    from sensorless.files import check_writable
    from sensorless.pil.pil import passed, pil
    from sensorless.pil.report import table, write_report
    from sensorless.policy import design_for

    check_writable(out, ending=".json")
    made = bench_of([run], motor, settings, override)
    policy = made.policy(run)
    schedule, design = table_of(policy, run), design_for(policy, made.design)
    columns = (TextColumn("closed loop on the target"), BarColumn(), TimeElapsedColumn())
    say = minutely()

    def progress(done: float) -> None:
        bar.update(task, completed=done)
        say(f"closed loop on the target: {100.0 * done:.0f} %")

    with Progress(*columns, console=errors, disable=not errors.is_terminal) as bar:
        task = bar.add_task("", total=1.0)
        report = pil(
            schedule,
            made.motor,
            design,
            policy=policy.name,
            progress=progress,
        )
    console.print(table(report))
    if out is not None:
        write_report(report, out)
        say_wrote(out)
    if as_json:
        say_json(report)
    if not passed(report):
        raise UserError("pil: the target computes other bits than the host; see the table")

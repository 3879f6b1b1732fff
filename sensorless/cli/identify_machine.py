"""The command ``sensorless identify machine``: the drive measures itself."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    ReplaceOption,
    console,
    errors,
    say_json,
    say_wrote,
)


def machine_command(
    motor: MotorOption = "paper",
    log: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Evaluate this log of the same procedure instead of the simulated drive. Default: "
            "simulate.",
        ),
    ] = None,
    save_log: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv", help="Write all that the drive measured. Default: no file."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.toml", help="Write a motor file. Default: no file."),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            help="Draw the errors of the simulated sensors and inverter from this seed.",
        ),
    ] = 0,
    replace: ReplaceOption = False,  # apart.py reads it, before the command runs
    as_json: JsonOption = False,
) -> None:
    """Measure resistance, flux linkages, magnet and inertia with the drive's own sensors.

    Of the motor file the procedure knows the rating, the drive and the pole pairs; all else is what
    it measures. The simulated drive has errors of sensors and inverter as in the suite stress. The
    shaft has to be free: it turns, up to 45 % of rated speed. A number that cannot be identified
    ends the procedure with the reason.

    For example:

        sensorless identify machine --motor paper --out mine.toml
        sensorless identify machine --motor paper --log measured.csv --out mine.toml
    """
    from sensorless.errors import UserError
    from sensorless.files import check_writable, write_atomic
    from sensorless.identify.machine.log import plausible, read_log, write_log
    from sensorless.identify.machine.nameplate import Nameplate
    from sensorless.identify.machine.procedure import identify_machine
    from sensorless.identify.machine.readings import require_answers
    from sensorless.identify.machine.result import doubts, motor_tables, screen
    from sensorless.identify.machine.simulated import Simulated, real_drive
    from sensorless.identify.machine.source import Recorded, Source
    from sensorless.machine.motor import Motor
    from sensorless.machine.motor_file import check_motor_out, written
    from sensorless.suitability.plausible import require_plausible

    check_writable(save_log, "save-log")
    check_motor_out(out)
    given = Motor.load(motor)
    if log is None:
        require_plausible(given)
    source: Source
    if log is None:
        source = Simulated(given, real_drive(given, seed))
    else:
        parts = plausible(read_log(log), given, log)
        require_answers(parts, given, f"log {str(log)!r}")
        source = Recorded(parts)
    try:
        found = identify_machine(source, Nameplate.of(given))
        data = motor_tables(found)
    except UserError as error:
        raise UserError(f"motor {given.name!r}: not identified: {error}") from None
    finally:
        if save_log is not None:
            write_log(source.parts, save_log)
    table = Table(
        title=f"{given.name}: identified by its drive",
        caption="scatter of the measurement; an error of the current sensors' mean gain comes on "
        "top, in full, in R_s, L_d, L_q and J",
    )
    for heading in ("", "value", "scatter", "from"):
        table.add_column(heading)
    for row in screen(found):
        table.add_row(*row)
    console.print(table)
    for doubt in doubts(data):
        errors.print(doubt, highlight=False, markup=False, soft_wrap=True)
    if as_json:
        say_json(data)
    say_wrote(save_log)
    if out is not None:
        how = "its simulated drive" if log is None else log.name
        head = (
            f"Identified from {how} by sensorless identify machine. An error of the current\n"
            "sensors' gain is in R_s and the inductances in full."
        )
        write_atomic(out, written(data, head))
        say_wrote(out)

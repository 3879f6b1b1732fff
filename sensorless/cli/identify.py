"""The commands ``sensorless identify ...``: what a commissioning run finds out."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from sensorless.cli.identify_bring_up import bring_up_command
from sensorless.cli.identify_machine import machine_command
from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    SetOption,
    console,
    say_if_unsuited,
    say_json,
    say_wrote,
)
from sensorless.cli.plain import Command, Group
from sensorless.cli.quiet import quietly

LEAST_CROSS = 0.01
"""Turn of the magnetic axes that is worth a fit [deg]."""

app = typer.Typer(cls=Group, no_args_is_help=True, rich_markup_mode="markdown")


@app.callback()
def identify() -> None:
    """Measure in a test run what the drive has to know about its machine.

    The drive runs its test on the simulated machine; a real drive would do the same.

    For example:

        sensorless identify bring-up --motor paper
        sensorless identify machine --motor paper --out mine.toml
        sensorless identify cross-coupling --out cross.json
    """


app.command("bring-up", cls=Command)(quietly(bring_up_command))
app.command("machine", cls=Command)(quietly(machine_command))


@app.command("cross-coupling", cls=Command)
@quietly
def cross_coupling(
    motor: MotorOption = "paper",
    settings: SetOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Write sweep and fits as JSON; `--set cross=FILE.json` makes a drive use them. "
            "Default: no file.",
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png", help="Draw sweep and fits as a PNG picture. Default: no picture."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Measure the angle between the rotor and the injection estimate over the torque current.

    Cross-coupling, saturation of one axis by the current of the other, turns the injection
    estimate off the rotor (Fig. 4 of the source paper). The drive sweeps the load in both torque
    directions at 10 % of rated speed on the injection estimator alone, without compensation, while
    an encoder watches. A line and a table are fitted to the angle, truth minus estimate, and the
    table is tried in the drive. The line is fitted up to the torque `cross_line_torque`.

    For example:

        sensorless identify cross-coupling --out cross.json
        sensorless simulate --set cross=cross.json --speed 0:150 --load 0:6
    """
    from sensorless.design.words import design_from
    from sensorless.files import check_writable
    from sensorless.identify.cross_coupling import identify_cross_coupling
    from sensorless.machine.motor import Motor
    from sensorless.plots.figure import check_picture

    check_writable(out, ending=".json")
    check_picture(plot)
    machine, design = Motor.load(motor), design_from(settings)
    say_if_unsuited(machine, design)
    found = identify_cross_coupling(machine, design)
    r = found.report()
    table = Table(title=f"{r['motor']}: cross-coupling angle, truth − injection estimate")
    for heading in ("fit", "slope [°/A]", "R²", "residual rms [°]", "largest [°]"):
        table.add_column(heading, justify="left" if heading == "fit" else "right")
    line = r["line"]
    fits = {
        f"line to {line['fitted_up_to_A']:.2f} A": line,
        "· torque > 0": line["positive_torque"],
        "· torque < 0": line["negative_torque"],
        "· to rated": line["to_rated_current"],
        "table": r["table"],
    }
    for name, fit in fits.items():
        slope = f"{fit['slope_deg_per_A']:.3f}" if "slope_deg_per_A" in fit else "–"
        table.add_row(
            name,
            slope,
            f"{fit['r2']:.5f}",
            f"{fit['residual_rms_deg']:.2f}",
            f"{fit['residual_max_deg']:.2f}",
        )
    console.print(table)
    console.print(
        f"closed form within {r['closed_form_max_gap_deg']:.2f}° of the sweep; "
        f"drive on the table within {r['left_with_table_max_deg']:.2f}°, "
        f"on the line within {r['left_with_line_max_deg']:.2f}° where it was fitted"
    )
    if max(map(abs, r["sweep"]["closed_form_deg"])) < LEAST_CROSS:
        console.print("no cross-coupling: the motor's file has none, so the fits are of noise")
    if as_json:
        say_json(r)
    if out is not None:
        found.write(out)
        say_wrote(out)
    if plot is not None:
        from sensorless.plots.cross_coupling import cross_coupling as draw
        from sensorless.plots.figure import save

        save(draw(found), plot)
        say_wrote(plot)

"""The commands ``sensorless identify ...``: what a commissioning run finds out."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

app = typer.Typer(no_args_is_help=True, help="Find out by a test run what the drive has to know.")
console = Console()


@app.callback()
def identify() -> None:
    """Find out by a test run what the drive has to know about its machine."""


@app.command("cross-coupling")
def cross_coupling(
    motor: Annotated[
        str, typer.Option("--motor", help="Shipped motor by name, or a TOML file.")
    ] = "paper",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Drive design, e.g. mtpa=false."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Sweep and fits as JSON.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture as PNG.")] = None,
) -> None:
    """Angle between rotor and injection estimate over the torque current (Fig. 4).

    A load sweep in both torque directions at 10 % of rated speed, on the injection estimator alone,
    compensation off and an encoder watching; then a line and a table are fitted, and the table is
    tried in the drive. The line is fitted up to cross_line_torque of the design and judged in both
    torque directions. The drive runs on the file that this writes with --set cross=FILE.json.
    Angles are truth minus estimate.
    """
    from sensorless.design.words import design_from
    from sensorless.files import check_writable
    from sensorless.identify.cross_coupling import identify_cross_coupling
    from sensorless.machine.motor import Motor

    check_writable(out)
    check_writable(plot, "plot")
    found = identify_cross_coupling(Motor.load(motor), design_from(settings))
    r = found.report()
    table = Table(title=f"{r['motor']}: θm/2, truth − injection estimate")
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
    if out is not None:
        found.write(out)
        console.print(f"wrote {out}")
    if plot is not None:
        from sensorless.plots.cross_coupling import cross_coupling as draw
        from sensorless.plots.figure import save

        save(draw(found), plot)
        console.print(f"wrote {plot}")

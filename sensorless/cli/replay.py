"""The command ``sensorless replay``."""

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

console = Console()


def replay_command(
    log: Annotated[
        Path,
        typer.Argument(
            help="CSV file with one row a PWM period (docs/replay.md), or the word sample for the "
            "log that comes with the package."
        ),
    ],
    motor: Annotated[
        str, typer.Option("--motor", help="Shipped motor by name, or a TOML file.")
    ] = "paper",
    policy: Annotated[str, typer.Option(help="Rule or table for k_s, as in evaluate.")] = "eq25",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Drive design, e.g. smo_pll_hz=30."),
    ] = None,
    angle: Annotated[float, typer.Option(help="First angle, electrical [deg].")] = 0.0,
    speed: Annotated[float, typer.Option(help="First speed [r/min].")] = 0.0,
    delay: Annotated[
        int,
        typer.Option(help="Rows from a voltage to where it acts: 0 acts at once, 1 a command."),
    ] = 0,
    after: Annotated[float, typer.Option(min=0.0, help="Errors count from here on [s].")] = 0.0,
    out: Annotated[Path | None, typer.Option(help="Estimates as CSV.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture as PNG.")] = None,
) -> None:
    """Run the observers, their blend and a Kalman filter over a recorded log.

    The log has time, two or three phase currents and the applied voltages or duty cycles; with an
    encoder angle the errors are known. No estimator sees the encoder.
    """
    from sensorless.design.words import design_from
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policy
    from sensorless.replay.replay import SAMPLE, load, replay

    check_writable(out)
    check_writable(plot, "plot")
    machine, design = Motor.load(motor), design_from(settings)
    log = SAMPLE if log == Path("sample") and not log.exists() else log
    rule = make_policy(policy, machine)
    found = replay(
        load(log, machine, design, delay),
        machine,
        design,
        rule,
        theta_0=math.radians(math.remainder(angle, 360.0)),
        omega_0=machine.rpm_to_electrical(speed),
    )
    console.print(found.table(after))
    if out is not None:
        found.write_csv(out)
        console.print(f"wrote {out}")
    if plot is not None:
        from sensorless.plots.figure import save
        from sensorless.plots.replayed import replayed

        save(replayed(found), plot)
        console.print(f"wrote {plot}")

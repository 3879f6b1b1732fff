"""The command ``sensorless replay``."""

import math
from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    PolicyOption,
    SetOption,
    bench_of,
    console,
    errors,
    say_json,
    say_wrote,
)


def replay_command(
    log: Annotated[
        Path,
        typer.Argument(
            metavar="LOG.csv",
            help="Read this log: CSV of any kind or MATLAB, one row per PWM period, with the "
            "columns of docs/replay.md. The word `sample` reads the log that comes with the "
            "package.",
        ),
    ],
    motor: CarriedMotorOption = None,
    policy: PolicyOption = "eq25",
    settings: SetOption = None,
    override: OverrideOption = False,
    angle: Annotated[
        float, typer.Option(help="Start the estimators at this angle [electrical degrees].")
    ] = 0.0,
    speed: Annotated[
        float, typer.Option(help="Start the estimators at this speed of the shaft [r/min].")
    ] = 0.0,
    delay: Annotated[
        int,
        typer.Option(
            help="Shift the logged voltages by this many rows: 0 if a row holds the voltage that "
            "acts in its period, 1 if it holds the command for the next."
        ),
    ] = 0,
    names: Annotated[
        list[str] | None,
        typer.Option(
            "--map",
            metavar="NAME=COLUMN",
            help="Read a column under the name it has in the file: i_a=Ia, or i_a=-Ia to "
            "turn its sign; repeat the option for several, or give a TOML file of such lines. "
            "Default: the names of docs/replay.md.",
        ),
    ] = None,
    after: Annotated[
        float,
        typer.Option(
            metavar="<float>", min=0.0, help="Count errors only from this time of the log on [s]."
        ),
    ] = 0.0,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Write the estimates as CSV. Default: no file."),
    ] = None,
    as_json: JsonOption = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Draw the estimates: FILE.png as a picture, FILE.html as a page to zoom in. "
            "Default: neither.",
        ),
    ] = None,
) -> None:
    """Run the drive's estimators and a Kalman filter over the log of a real drive.

    The log has time, two or three phase currents, and the applied voltages or duty cycles. If it
    also has the angle of an encoder, the errors are printed; no estimator sees the encoder.

    For example:

        sensorless replay sample --after 0.05 --plot replay.png
        sensorless replay drive.csv --motor my.toml --out estimates.csv
        sensorless replay scope.csv --map i_a=Ia --map i_b=Ib
    """
    from sensorless.files import check_writable
    from sensorless.policy import design_for
    from sensorless.replay.judgement import judgement
    from sensorless.replay.mapping import names_from
    from sensorless.replay.replay import SAMPLE, load, replay
    from sensorless.report.picture import check_drawable, write_waves

    check_writable(out, ending=".csv")
    check_drawable(plot)
    made = bench_of([policy], motor, settings, override)
    rule = made.policy(policy)
    machine, design = made.motor, design_for(rule, made.design)
    log = SAMPLE if log == Path("sample") and not log.exists() else log
    found = replay(
        load(log, machine, design, delay, names_from(names)),
        machine,
        design,
        rule,
        theta_0=math.radians(angle),
        omega_0=machine.rpm_to_electrical(speed),
    )
    table = found.table(after)
    for note in found.notes:
        errors.print(f"note: {note}", highlight=False, soft_wrap=True)
    if as_json:
        say_json({"estimators": found.summary(after), "notes": found.notes})
    else:
        console.print(table)
        for line in judgement(found, after):
            console.print(line, highlight=False, soft_wrap=True)
    if out is not None:
        found.write_csv(out)
    if plot is not None:
        from sensorless.plots.replayed import replayed
        from sensorless.versions import typed

        title = f"{log.name} on {machine.name}, k_s: {rule.name}"
        said = (*found.notes, *judgement(found, after))
        write_waves([replayed(found, title)], plot, typed(), said)
    say_wrote(out, plot)

"""The command ``sensorless motor check``: whether a motor suits this drive."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sensorless.cli.options import (
    JsonOption,
    SetOption,
    console,
    say_json,
    say_wrote,
)

if TYPE_CHECKING:
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor


def check_command(
    file: Annotated[
        str, typer.Argument(help="Check this motor: a TOML file, or the name of a shipped one.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(help="Write findings and figures as one HTML page. Default: no page."),
    ] = None,
    size: Annotated[
        int,
        typer.Option(
            min=0, metavar="N", help="Simulate this many scenarios of each suite; 0: none."
        ),
    ] = 100,
    settings: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Tell whether a motor suits this drive: yes, with limits, or no, and why.

    The check looks for implausible numbers, compares the rated point with current and voltage,
    follows saliency and cross-coupling over the current, compares injection's signal with noise,
    and suggests settings. Unless the answer is no already, it then simulates Eq. 25, the source
    paper's rule: on scenarios of the suite stress, and on as many each of the suites handoff, hold,
    unload, braking, stop, impact, reversal and mismatch, in the last of which the motor is not as
    its file says; and without load, at six speeds, on an inverter that switches. Exit status 1: the
    answer is no.

    For example:

        sensorless motor check mine.toml --out mine.html
    """
    from sensorless.design.words import design_from
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor

    check_writable(out, ending=".html")
    show_check(Motor.load(file), design_from(settings), size, out, as_json)


def show_check(
    motor: "Motor", design: "DriveDesign", size: int, out: Path | None, as_json: bool
) -> None:
    """Check a motor under a design; print the findings and the verdict, and write the page.

    Raises
    ------
    typer.Exit
        With status 1 if the motor does not suit.
    """
    from sensorless.report.motor_check import check, facts, screen, write_page
    from sensorless.versions import typed

    done = check(motor, design, size)
    console.print(screen(done))
    verdict = done.examination.verdict
    console.print(verdict.head, style="bold", highlight=False)
    for reason in verdict.because:
        console.print(f"- {reason}", highlight=False, markup=False)
    if as_json:
        say_json(facts(done))
    if out is not None:
        write_page(done, out, design, typed())
        say_wrote(out)
    if verdict.word == "no":
        raise typer.Exit(1)

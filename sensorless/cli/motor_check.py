"""The command ``sensorless motor check``: is this motor suitable."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from sensorless.cli.options import SetOption, console

if TYPE_CHECKING:
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor


def check_command(
    file: Annotated[str, typer.Argument(help="Motor file, or a shipped motor by name.")],
    out: Annotated[
        Path | None, typer.Option(help="Write the same as one HTML page. Default: none.")
    ] = None,
    size: Annotated[
        int, typer.Option(min=0, metavar="N", help="Scenarios of the quick run; 0: no run.")
    ] = 100,
    settings: SetOption = None,
) -> None:
    """Tell whether a motor suits this drive: yes, with limits, or no, and why.

    The check looks for slips of unit, holds the rated point against current and voltage, follows
    saliency and cross-coupling over the current, weighs the signal of injection against noise, and
    suggests settings. Then it runs Eq. 25 on some scenarios of suite stress-1.

    For example:

        sensorless motor check mine.toml --out mine.html
    """
    from sensorless.design.words import design_from
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.plots.figure import require_matplotlib

    check_writable(out)
    if out is not None:
        require_matplotlib()
    show_check(Motor.load(file), design_from(settings), size, out, f"sensorless motor check {file}")


def show_check(
    motor: "Motor", design: "DriveDesign", size: int, out: Path | None, command: str
) -> None:
    """Check a motor under a design and show it: screen, verdict, page."""
    from sensorless.report.motor_check import check, screen, write_page

    done = check(motor, design, size)
    console.print(screen(done))
    console.print(f"[bold]{escape(str(done.examination.verdict))}[/]", highlight=False)
    if out is not None:
        write_page(done, out, command)
        console.print(f"wrote {out}")

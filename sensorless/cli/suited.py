"""A warning about unsuitable machines, before minutes of work on them."""

from typing import TYPE_CHECKING

from rich.markup import escape

from sensorless.cli.options import errors

if TYPE_CHECKING:
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor


def say_if_unsuited(motor: "Motor", design: "DriveDesign") -> None:
    """Print the verdict of the check without its simulation, unless it is yes."""
    from sensorless.design.derived import derive
    from sensorless.suitability.examine import examine

    verdict = examine(motor, derive(motor, design).hfi_pll_hz).verdict
    if verdict.word != "yes":
        errors.print(f"[bold]{escape(motor.name)}[/]: {escape(str(verdict))}", highlight=False)

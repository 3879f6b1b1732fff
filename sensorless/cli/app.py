"""The command ``sensorless``: its commands in the order in which a newcomer meets them."""

from collections.abc import Callable
from typing import Annotated

import typer

from sensorless.cli.certify import certify_command
from sensorless.cli.demo import demo_command
from sensorless.cli.distill import distill_command
from sensorless.cli.evaluate import evaluate_command
from sensorless.cli.export import export_command
from sensorless.cli.falsify import falsify_command
from sensorless.cli.identify import app as identify_app
from sensorless.cli.motor import app as motor_app
from sensorless.cli.motors import motors_command
from sensorless.cli.options import console
from sensorless.cli.pil import pil_command
from sensorless.cli.plain import Command, Group
from sensorless.cli.quiet import quietly
from sensorless.cli.replay import replay_command
from sensorless.cli.report import report_command
from sensorless.cli.reproduce import reproduce_command
from sensorless.cli.settings import settings_command
from sensorless.cli.simulate import simulate_command
from sensorless.cli.train import train_command
from sensorless.cli.tune import tune_command
from sensorless.cli.tune_gains import tune_gains_command

PANELS: dict[str, dict[str, Callable[..., None]]] = {
    "Look": {"demo": demo_command, "simulate": simulate_command, "reproduce": reproduce_command},
    "Make a schedule": {
        "train": train_command,
        "tune": tune_command,
        "tune gains": tune_gains_command,
        "distill": distill_command,
    },
    "Judge it": {
        "evaluate": evaluate_command,
        "certify": certify_command,
        "falsify": falsify_command,
        "report": report_command,
    },
    "Ship it": {"export": export_command, "pil": pil_command},
    "Your own drive": {
        "motors": motors_command,
        "settings": settings_command,
        "replay": replay_command,
    },
}
"""Functions by command and by the heading above it."""

app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if not wanted:
        return
    from sensorless.versions import versions

    known = versions(())
    console.print(
        f"sensorless {known['sensorless']}, core {known['core']}, Python {known['python']}",
        highlight=False,
    )
    raise typer.Exit


@app.callback()
def sensorless(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            help="Print the versions of this package, its C core and Python, and exit.",
            is_eager=True,
            callback=_version,
        ),
    ] = False,
) -> None:
    """Run a permanent-magnet motor without a position sensor, and learn when to switch estimators.

    A drive without a sensor has two ways to find its rotor. At low speed it injects a
    high-frequency voltage and reads the answer (HFI); at higher speed an observer, the
    coupled one by default or the source paper's sliding-mode observer (SMO), reads the motor's
    own voltage. A weight k_s blends the two: 1 is all
    HFI, 0 all observer. A schedule is the rule for k_s, and the hand-over between the two is where
    drives lose their rotor. This program simulates such a drive, trains schedules with PPO, judges
    them against the rules that drives ship, and exports them as C code.

    First steps:

        sensorless demo
        sensorless train --minutes 5 --name first
        sensorless evaluate --policy eq25 --policy runs/first --suite stress-1
        sensorless export runs/first --out firmware_first

    Every command explains itself: `sensorless COMMAND --help`.
    """


for _panel, _commands in PANELS.items():
    for _name, _function in _commands.items():
        app.command(_name, cls=Command, rich_help_panel=_panel)(quietly(_function))
app.add_typer(motor_app, name="motor", rich_help_panel="Your own drive")
app.add_typer(identify_app, name="identify", rich_help_panel="Your own drive")

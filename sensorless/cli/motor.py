"""The commands ``sensorless motor ...``, which make and check motor files."""

from collections.abc import Callable

import typer

from sensorless.cli.motor_check import check_command
from sensorless.cli.motor_import_map import import_map_command
from sensorless.cli.motor_new import new_command
from sensorless.cli.plain import Command, Group
from sensorless.cli.quiet import quietly

app = typer.Typer(cls=Group, no_args_is_help=True, rich_markup_mode="markdown")


@app.callback()
def motor() -> None:
    """Write a motor file from a datasheet or a flux map, and check whether the motor suits.

    docs/motor-file.md shows how such a file is laid out.

    For example:

        sensorless motor new --name mine --out mine.toml
        sensorless motor check mine.toml --out mine.html
    """


COMMANDS: dict[str, Callable[..., None]] = {
    "new": new_command,
    "import-map": import_map_command,
    "check": check_command,
}

for _name, _function in COMMANDS.items():
    app.command(_name, cls=Command)(quietly(_function))

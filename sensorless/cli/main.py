"""Entry point of the program: a user error is one line on the terminal, without a traceback."""

import os
import sys

from rich.markup import escape

from sensorless.cli.options import errors
from sensorless.errors import StaleCoreError, UserError


def main() -> None:
    """Run the command line; a user error exits with status 2, Ctrl-C with status 130."""
    try:
        from sensorless.cli.app import app  # here, so that a stale core is one line, too

        app(standalone_mode=True)
    except (UserError, StaleCoreError) as error:
        errors.print(f"[bold red]error:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2)
    except KeyboardInterrupt:
        errors.print("interrupted")
        sys.exit(130)
    except BrokenPipeError:
        os._exit(1)

"""Entry point of the program: what goes wrong is one line on the terminal, without a traceback."""

import os
import sys
from traceback import extract_tb

from rich.text import Text

from sensorless.cli.options import errors
from sensorless.cli.surroundings import Signalled, ended_by_signals, never_fail_to_print
from sensorless.errors import StaleCoreError, UserError
from sensorless.files import reason

TRACEBACK = "SENSORLESS_TRACEBACK"
"""Set this variable to see where an error of the program itself came from."""


NO_MEMORY = "not enough memory; free some, or ask for less: a smaller --size, --n-envs or file"
UNMAPPED = "failed to map segment"
"""What the loader says of a library, such as that of torch, for which there is no memory."""


def main() -> None:
    """Run the command line; the exit status tells how it ended.

    0: done; 2: a user error, or a computer that cannot do it (full disk, little memory); 70: an
    error of the program itself; 130: Ctrl-C; 128 and its number: a signal.
    """
    never_fail_to_print()
    with ended_by_signals() as came:
        try:
            _run()
        except SystemExit:
            if came:
                sys.exit(128 + came[-1])
            raise


def _run() -> None:
    try:
        from sensorless.cli.app import app  # here, so that a stale core is one line, too

        app(standalone_mode=True)
    except SystemExit as end:
        asked = getattr(end.__context__, "__cause__", None)  # typer ends silently on Ctrl-C
        if isinstance(asked, KeyboardInterrupt):
            _interrupted(asked)
        raise
    except (UserError, StaleCoreError) as error:
        _say(str(error))
        sys.exit(2)
    except KeyboardInterrupt as stop:
        _interrupted(stop)
        sys.exit(130)
    except BrokenPipeError:
        os._exit(1)
    except OSError as error:
        what = "" if error.filename is None else f"{str(error.filename)!r}: "
        _say(f"{what}{reason(error)}; free or change what it names, then rerun the command")
        sys.exit(2)
    except MemoryError:
        _say(NO_MEMORY)
        sys.exit(2)
    except Exception as error:
        if isinstance(error, ImportError) and UNMAPPED in str(error):
            _say(NO_MEMORY)
            sys.exit(2)
        if os.environ.get(TRACEBACK):
            raise
        at = extract_tb(error.__traceback__)[-1]
        said = next(iter(str(error).splitlines()), "")
        _say(
            f"{type(error).__name__} in {at.filename}, line {at.lineno}: {said}; this is an error "
            f"of the program: please report it, with what {TRACEBACK}=1 shows"
        )
        sys.exit(70)


def _interrupted(stop: KeyboardInterrupt) -> None:
    errors.print("ended by a signal" if isinstance(stop, Signalled) else "interrupted")


def _say(text: str) -> None:
    errors.print(Text("error:", "bold red"), text, highlight=False, soft_wrap=True)

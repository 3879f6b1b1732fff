"""``--quiet`` for every command, and an output that is JSON alone where ``--json`` asks for it."""

import functools
import inspect
from collections.abc import Callable
from typing import Any

from sensorless.cli.options import QuietOption, console, errors


def quietly(function: Callable[..., None]) -> Callable[..., None]:
    """``function`` with the option ``--quiet``; with ``as_json`` its consoles print nothing."""

    @functools.wraps(function)
    def command(*, quiet: bool = False, **given: Any) -> None:
        errors.quiet, console.quiet = quiet, bool(given.get("as_json", False))
        try:
            function(**given)
        finally:
            errors.quiet = console.quiet = False

    own = inspect.signature(function).parameters.values()
    last = inspect.Parameter(
        "quiet", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=QuietOption
    )
    command.__signature__ = inspect.Signature([*own, last])  # type: ignore[attr-defined]
    command.__annotations__ = {p.name: p.annotation for p in [*own, last]}
    return command

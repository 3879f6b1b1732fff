"""Which options of a command the user gave, and those of them that would do nothing."""

import typer

from sensorless.errors import UserError

PLANS = ("speed", "load", "ramp", "duration", "seed", "start", "theta_err", "spin")
DRIVE = ("motor", "policy", "scenario", "settings", "override", "plot", "show", "save_log")
IDLE = {
    "scenario": (PLANS, "a scenario has its own; leave one of the two out"),
    "plant": ((*PLANS, *DRIVE, "as_json"), "a machine alone has no drive; leave one of them out"),
}
"""By an option of ``simulate`` that was given: those that do nothing beside it, and why."""


def was_given(context: typer.Context, name: str) -> bool:
    """Whether an option of a command was given."""
    source = context.get_parameter_source(name)
    return source is not None and source.name != "DEFAULT"


def refuse_idle(context: typer.Context) -> None:
    """Check the options of ``simulate``.

    Raises
    ------
    UserError
        One of them does nothing; the message names it and the other.
    """
    names = {str(p.name): p.opts[0].lstrip("-") for p in context.command.params}
    for key, (idle, why) in IDLE.items():
        wrong = next((name for name in idle if was_given(context, name)), None)
        if was_given(context, key) and wrong is not None:
            raise UserError(f"{names[wrong]}, {names[key]}: {why}")
    if was_given(context, "show") and not was_given(context, "plot"):
        raise UserError("show: there is no picture; give --plot FILE.png, or leave it out")

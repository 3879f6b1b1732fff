"""Refuses options that others make pointless: what was asked for would not be done."""

from typing import Any

from sensorless.errors import UserError

PLANS = ("speed", "load", "ramp", "duration", "seed", "start", "theta_err", "spin")
DRIVE = ("motor", "policy", "scenario", "settings", "override", "plot", "show", "save_log")
IDLE = {
    "scenario": (PLANS, "a scenario has its own; leave one of the two out"),
    "plant": ((*PLANS, *DRIVE, "as_json"), "a machine alone has no drive; leave one of them out"),
}
"""By an option of ``simulate`` that was given: those that do nothing beside it, and why."""


def refuse_unused(ctx: Any) -> None:
    """Check the options that the user gave.

    Raises
    ------
    UserError
        One of them does nothing; the message names it and the other.
    """
    named = [word.partition("=")[0] for word in ctx.params.get("settings") or ()]
    twice = next((name for name in named if named.count(name) > 1), None)
    if twice is not None:
        raise UserError(f"set: {twice}: given twice; give it once")
    if ctx.info_name != "simulate":
        return
    names = {p.name: p.opts[0].lstrip("-") for p in ctx.command.params}
    given = [n for n in names if ctx.get_parameter_source(n).name == "COMMANDLINE"]
    for key, (idle, why) in IDLE.items():
        wrong = [name for name in given if name in idle]
        if key in given and wrong:
            raise UserError(f"{names[wrong[0]]}, {names[key]}: {why}")
    if "show" in given and "plot" not in given:
        raise UserError("show: there is no picture; give --plot FILE.png, or leave it out")

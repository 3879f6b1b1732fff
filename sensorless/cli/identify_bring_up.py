"""The command ``sensorless identify bring-up``: whether a drive is integrated correctly."""

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    console,
    say_json,
)


def bring_up_command(
    motor: MotorOption = "paper",
    log: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Judge this log of `bring_up_step` on a real drive: columns i_a and i_b [A], one "
            "row per PWM period. Default: simulate.",
        ),
    ] = None,
    mistake: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Simulate one drive with this mistake (`right`: with none) and judge it. Default: "
            "count on many drives how often each mistake is found.",
        ),
    ] = None,
    size: Annotated[
        int, typer.Option(metavar="N", min=1, max=10000, help="Count on this many drives.")
    ] = 20,
    seed: Annotated[
        int, typer.Option(metavar="N", min=0, help="Draw the drives from this seed.")
    ] = 0,
    save_log: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv", help="Write what was sampled with --mistake. Default: no file."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Check how a drive is built in: delay, signs, phases, duty formula, dead time, pole pairs.

    The check is `core/drive/bring_up.h`: voltage pulses at rest, before the first `drive_step`.
    Firmware runs it; this command reads a log of it, or shows on simulated drives, with the errors
    of the suite stress, what it makes of each mistake. Exit status 1: a fault was found.

    For example:

        sensorless identify bring-up --motor paper
        sensorless identify bring-up --mistake delay-2 --save-log pulses.csv
        sensorless identify bring-up --log pulses.csv
    """
    import numpy as np

    from sensorless.envs.counter_random import check_seed
    from sensorless.errors import UserError
    from sensorless.files import check_writable
    from sensorless.identify.bring_up.check import check, check_log, drives_at_rest, write_log
    from sensorless.identify.bring_up.mistakes import MISTAKES, RIGHT
    from sensorless.identify.bring_up.survey import count_pole_pairs, survey, turning_drive
    from sensorless.identify.bring_up.words import verdict
    from sensorless.machine.motor import Motor
    from sensorless.observers.bring_up_design import plan_bring_up
    from sensorless.suitability.plausible import require_plausible

    check_writable(save_log, "save-log")
    check_seed(seed)
    machine = Motor.load(motor)
    require_plausible(machine)
    limits = plan_bring_up(machine).limits
    if mistake is not None and mistake != "right" and mistake not in MISTAKES:
        raise UserError(f"mistake: {mistake!r}; choose right, {', '.join(MISTAKES)}")
    if log is not None and (mistake is not None or save_log is not None):
        raise UserError(
            "log: a log of a real drive is judged alone; leave out --mistake, --save-log"
        )
    if save_log is not None and mistake is None:
        raise UserError("save-log: a count has no log; add --mistake NAME")
    if log is not None or mistake is not None:
        if log is not None:
            found = check_log(machine, log)
        else:
            drive = drives_at_rest(machine, np.array([seed], dtype=np.uint64))
            found, rows = check(machine, drive, MISTAKES.get(str(mistake), RIGHT))
            if save_log is not None:
                write_log(rows, save_log)
        for line in (*verdict(found), *limits):
            console.print(line, highlight=False)
        if as_json:
            say_json({"faults": list(found.faults), "said": verdict(found), "limits": limits})
        if found.faults or found.other_pulses:
            raise typer.Exit(1)
        return
    table = Table(title=f"{machine.name}: {size} drives with the errors of the suite stress")
    for heading in ("built in", "flagged", "named"):
        table.add_column(heading, justify="left" if heading == "built in" else "right")
    told: dict[str, dict[str, int]] = {}
    for name, n in survey(machine, np.arange(seed, seed + size, dtype=np.uint64)):
        told[name] = {"drives": n.drives, "flagged": n.flagged, "named": n.named}
        named = "" if name == "right" else f"{n.named} of {n.drives}"
        table.add_row(name, f"{n.flagged} of {n.drives}", named)
    console.print(table)
    pairs = count_pole_pairs(turning_drive(machine, seed))
    console.print(f"pole pairs counted in a turn of the shaft: {pairs}; motor file: {machine.n_p}")
    for line in limits:
        console.print(line, highlight=False)
    if as_json:
        say_json(
            {
                "built_in": told,
                "pole_pairs": pairs,
                "pole_pairs_of_the_file": machine.n_p,
                "limits": limits,
            }
        )

"""The command ``sensorless report``."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import MotorOption, SetOption, console, policy_progress
from sensorless.errors import UserError


def report_command(
    run: Annotated[
        str,
        typer.Argument(help="Folder of a training run, or any other policy of evaluate --list."),
    ],
    out: Annotated[
        Path | None, typer.Option(help="Folder to write; default: report in the run's folder.")
    ] = None,
    suite: Annotated[
        list[str] | None,
        typer.Option("--suite", help="Suite to judge on; repeatable. Default: stress, handoff."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Draws the scenarios.")] = 7,
    size: Annotated[int, typer.Option(min=2, help="Scenarios of a suite.")] = 400,
    grid: Annotated[
        int, typer.Option(min=2, max=201, help="Points of the envelope maps along an axis.")
    ] = 21,
    policy: Annotated[
        list[str] | None,
        typer.Option(
            "--policy",
            help="Compare with this one; repeatable. Default: eq25, every tuned rule that is "
            "shipped, oracle, sensored.",
        ),
    ] = None,
    motor: MotorOption = "paper",
    settings: SetOption = None,
) -> None:
    """Judge a schedule and write one HTML page about it, with its figures as PNG beside it.

    The page needs no other file: results with intervals, losses by quadrant and speed, worst
    cases, what holds lock over speed and load, the schedule beside Eq. 25, waveforms of hand-overs,
    learning curves, and the commands that make each of them again.
    """
    from sensorless.design.words import design_from
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policy
    from sensorless.report.report import SUITES, Report

    machine = Motor.load(motor)
    make_policy(run, machine)  # a word that means nothing is told before anything else
    if out is None and not Path(run).is_dir():
        raise UserError(f"out: {run!r} is no folder to write into; allowed: with --out FOLDER")
    folder = Path(run) / "report" if out is None else out
    options = [] if motor == "paper" else ["--motor", motor]
    options += [word for setting in settings or [] for word in ("--set", setting)]
    with policy_progress() as progress:
        page = Report(
            run,
            machine,
            design_from(settings),
            others=policy,
            options=options,
            progress=progress,
        ).write(
            folder, suite or SUITES, seed, size, grid, shlex.join(["sensorless", *sys.argv[1:]])
        )
    console.print(f"wrote {page}", soft_wrap=True)

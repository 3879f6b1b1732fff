"""The command ``sensorless report``."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    POLICIES,
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    SeedOption,
    SetOption,
    bench_of,
    given_again,
    policy_progress,
    say_json,
    say_verdict,
    say_wrote,
)
from sensorless.errors import UserError


def report_command(
    run: Annotated[
        str,
        typer.Argument(metavar="POLICY", help=f"Report on this policy: {POLICIES}."),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Write to this folder. Default: the folder `report` inside the training run.",
        ),
    ] = None,
    suite: Annotated[
        list[str] | None,
        typer.Option(
            "--suite",
            metavar="SUITE",
            help="Judge on this suite of scenarios (`sensorless evaluate --help` explains them); "
            "repeat the option for several. Default: stress-1 and handoff.",
        ),
    ] = None,
    seed: SeedOption = 7,
    size: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=2,
            help="Draw this many scenarios per suite; machines has 16 on each of its machines.",
        ),
    ] = 400,
    grid: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=2,
            max=201,
            help="Map where lock holds on this many speeds and as many loads.",
        ),
    ] = 21,
    policy: Annotated[
        list[str] | None,
        typer.Option(
            "--policy",
            metavar="POLICY",
            help="Compare with this policy, and with eq25; repeat the option for several. Default: "
            "sliding_mode, oracle, sensored and, on the motor paper, every rule tuned for it "
            "(fuzzy ones where simpful is installed).",
        ),
    ] = None,
    motor: CarriedMotorOption = None,
    settings: SetOption = None,
    override: OverrideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Judge a policy and write one HTML page that says whether to flash it, and why.

    The page stands alone and opens with the verdict: beside Eq. 25, the linear rule of the source
    paper, and the best tuned rule, what is better, what is worse, and how sure that is. Below:
    all results, where it fails over speed and load, waveforms of its worst cases, the table beside
    Eq. 25, learning curves, commands and versions. Before it says yes, it checks the machine with
    the policy, as `sensorless export` does.

    For example:

        sensorless report runs/first --policy hysteresis --size 200
    """
    from sensorless.report.report import SUITES, Report
    from sensorless.versions import typed

    made = bench_of([run, *(policy or [])], motor, settings, override)
    if out is None and not Path(run).is_dir():
        raise UserError(
            f"out: {run!r} is not a training run's folder; say where to write with --out FOLDER"
        )
    folder = Path(run) / "report" if out is None else out
    if policy is None:  # what is shipped brings settings of its own, whatever --set asks for
        made = replace(made, override=True)
    with policy_progress() as progress:
        page, verdict = Report(
            run,
            made,
            others=policy,
            options=given_again(motor, settings, made.override),
            progress=progress,
        ).write(folder, suite or SUITES, seed, size, grid, typed())
    say_verdict(verdict.sentence)
    if as_json:
        say_json({"page": str(page), **asdict(verdict)})
    say_wrote(page)

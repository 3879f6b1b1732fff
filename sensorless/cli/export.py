"""The command ``sensorless export``."""

from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    SetOption,
    bench_of,
    console,
    errors,
    say_json,
    say_verdict,
)

ScheduleArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCHEDULE",
        help="Take this schedule: the folder of a training run, a file that `sensorless tune` "
        "wrote, or a rule that is a table, such as eq25, linear:LO,HI, smoothstep, fuzzy or "
        "constant:K.",
    ),
]


def export_command(
    run: ScheduleArgument,
    out: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER",
            help="Write to this folder: a new one, or an earlier export, which is replaced.",
        ),
    ],
    motor: CarriedMotorOption = None,
    settings: SetOption = None,
    override: OverrideOption = False,
    force: Annotated[
        bool,
        typer.Option(
            "--force",
            help="Export a schedule that is refused as unfit, with the verdict in its README.",
        ),
    ] = False,
    fit: Annotated[
        bool,
        typer.Option(
            "--fit/--no-fit",
            help="Also fit the two speed thresholds of a linear rule to the table, for firmware "
            "that cannot look up a table.",
        ),
    ] = True,
    as_json: JsonOption = False,
) -> None:
    """Write a schedule and the control core around it as C99, and check the copy.

    The folder holds the table in float32, in Q15 and in the layout of CMSIS-DSP, the control core,
    params.h, golden vectors (inputs with the outputs they must give) and a Makefile. If there is a
    C compiler, the self test is compiled and run at once: the C code must give every golden output
    to the bit. Motor and settings are those that the schedule was made with.

    Refused are a machine of which `sensorless motor check` says no on this drive, by its numbers or
    by its simulation, here with the schedule instead of Eq. 25; a drive that fails more than half
    of 200 scenarios of the suite nominal even with an encoder; a schedule that loses more than 5 %
    of those that an encoder drive can do; and one that is worse than Eq. 25 on the same drive: on
    400 scenarios of stress-1 its objective, 10 lost_rate + torque deviation + torque ripple, is
    higher, and the 95 % bootstrap interval of the difference excludes zero.

    For example:

        sensorless export runs/first --out firmware_first
    """
    from sensorless.export.export import export as write
    from sensorless.export.export import table_of
    from sensorless.export.folder import check_replaceable
    from sensorless.export.judge import judge_export, require_fit, verdict
    from sensorless.policy import design_for

    made = bench_of([run], motor, settings, override)
    policy = made.policy(run)
    table, design = table_of(policy, run), design_for(policy, made.design)
    check_replaceable(out.resolve())
    judged = judge_export(policy, made.motor, design)
    if not force:
        require_fit(judged, run)
    origin = {"motor_digest": made.motor.digest} if override else {}
    done = write(
        table,
        made.motor,
        design,
        out,
        policy=policy.name,
        provenance=origin,
        fit=fit,
        judged=judged,
    )
    errors.print(f"wrote {len(done.files)} files to {done.folder}", highlight=False, soft_wrap=True)
    console.print(done.self_test.message)
    say_verdict(verdict(judged))
    if as_json:
        facts = {"folder": str(done.folder), "files": list(done.files), **judged.facts()}
        say_json({**facts, "self_test": done.self_test.message})

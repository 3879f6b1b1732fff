"""The command ``sensorless evaluate``."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sensorless.cli.options import (
    POLICIES,
    CarriedMotorOption,
    EngineOption,
    JsonOption,
    OverrideOption,
    RayAddressOption,
    SeedOption,
    SetOption,
    bench_of,
    console,
    given_again,
    policy_progress,
    say_json,
    say_wrote,
)
from sensorless.errors import UserError

if TYPE_CHECKING:
    from sensorless.evaluation.results import Results


LONG = 24
"""Letters of a policy's name from which on its line stands below it."""


def list_policies(context: typer.Context, wanted: bool) -> None:
    """Print every policy with one line about it, or all as JSON, and exit."""
    if not wanted:
        return
    from sensorless.policies.registry import known

    lines = known()
    if context.params.get("as_json"):
        say_json(lines)
        raise typer.Exit
    width = max(len(name) for name in lines if len(name) <= LONG)
    for name, doc in lines.items():
        apart = "  " if len(name) <= width else f"\n{'':{width + 2}}"
        console.print(f"{name:{width}}{apart}{doc}", highlight=False, soft_wrap=True)
    raise typer.Exit


ListOption = Annotated[
    bool,
    typer.Option(
        "--list",
        help="List every policy with one line about it, and exit.",
        callback=list_policies,
    ),
]
PoliciesOption = Annotated[
    list[str],
    typer.Option(
        "--policy",
        metavar="POLICY",
        help=f"Judge this policy: {POLICIES}. Repeat the option to judge several; all are compared "
        "with the first.",
    ),
]
SuiteOption = Annotated[
    str,
    typer.Option(
        metavar="SUITE",
        help="Judge on this suite of scenarios: stress and stress-1 (everything at random), hold "
        "and crawl (loads at and near standstill), impact (rated load steps at all speeds), stop "
        "(rated speed to zero under load), unload (loads taken off), braking (held at low speed), "
        "sag (of the DC link under load), reversal (steps through zero), "
        "handoff (crossings between the estimators), mismatch (wrong parameters), "
        "low-inertia (15 to 50 % of the design's), hard and hard-train (what a search found), "
        "starts (unknown rotor angle), envelope (a grid of speed and load), nominal "
        "(stress-1 without errors of parameters and sensors), paper (figures of the "
        "source paper), motors (handoff and stress-1 by turns) or machines (stress-1 on random "
        "machines). docs/suites.md has them all.",
    ),
]


def evaluate_command(
    policy: PoliciesOption,
    motor: CarriedMotorOption = None,
    suite: SuiteOption = "stress-1",
    seed: SeedOption = 1,
    size: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=1,
            help="Draw this many scenarios; the suite envelope takes a square number, machines the "
            "number of machines, each with 16 scenarios.",
        ),
    ] = 200,
    settings: SetOption = None,
    override: OverrideOption = False,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Write the results as JSON. Default: no file."),
    ] = None,
    every: Annotated[
        bool,
        typer.Option(
            "--scenarios/--no-scenarios",
            help="Put the figures of every single scenario into the JSON, or only the summary.",
        ),
    ] = True,
    details: Annotated[
        bool,
        typer.Option(
            "--details",
            help="Print more tables: the hand-over, the differences to the first policy, losses by "
            "quadrant and by speed, and ten worst cases instead of three. Default: the summary.",
        ),
    ] = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png",
            help="Draw where each policy keeps lock over speed and load as a PNG picture; only "
            "with --suite envelope. Default: no picture.",
        ),
    ] = None,
    engine: EngineOption = "local",
    ray_address: RayAddressOption = None,
    as_json: JsonOption = False,
    listed: ListOption = False,
) -> None:
    """Judge policies on a suite: how often they lose lock, torque, speed and angle errors.

    A policy loses a scenario when the angle error stays above 60 electrical degrees for more than
    10 ms or the drive trips. Torque and speed errors count against the twin: the same drive in the
    same scenario with a position sensor. All figures come with 95 % intervals, and every policy is
    compared with the first one scenario by scenario. Training and tuning never see these
    scenarios. A lost drive runs on, so that its own alarm and recovery can be counted; nothing else
    counts that time. The same suite, seed and size give the same file to the bit, on any engine.

    A schedule runs on the motor and with the settings it was trained or tuned with, each on its
    own; rules by name take those of the command. `--set` and `--motor` that contradict a schedule
    are refused, unless `--override` lets them win.

    For example:

        sensorless evaluate --list
        sensorless evaluate --policy eq25 --policy runs/first --out results.json
        sensorless evaluate --policy eq25 --suite envelope --size 441 --plot map.png
    """
    from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
    from sensorless.envs.scenarios.machines_suite import refuse_motor
    from sensorless.evaluation.engines.named import engine_named
    from sensorless.evaluation.evaluate import evaluate as run
    from sensorless.evaluation.machines import evaluate_machines
    from sensorless.plots.figure import check_picture

    check_picture(plot)
    if plot is not None and suite != "envelope":
        raise UserError(
            f"plot: suite {suite!r} has no picture; use --suite envelope, or leave out --plot"
        )
    refuse_motor(suite, motor)
    made = bench_of(policy, motor, settings, override)
    with engine_named(engine, ray_address) as where, policy_progress() as report:
        if suite == MACHINES:
            results = evaluate_machines(
                made.design,
                seed,
                size,
                lambda own: made.on(own).policies(policy),
                out=out,
                every=every,
                progress=report,
                engine=where,
            )
        else:
            results = run(
                made.motor,
                made.design,
                suite,
                seed,
                size,
                made.policies(policy),
                out=out,
                every=every,
                progress=report,
                engine=where,
            )
    if plot is not None:
        from sensorless.plots.envelope import envelope_maps
        from sensorless.plots.figure import save

        save(envelope_maps(results, made.motor), plot)
    if as_json:
        typer.echo(results.to_json(scenarios=False))
    print_tables(
        results,
        machines=suite == MACHINES,
        details=details,
        given=shlex.join(given_again(motor, settings, override)),
    )
    say_wrote(plot, out)


def print_tables(results: "Results", *, machines: bool, details: bool, given: str) -> None:
    """Print what was found, over random machines or in detail if asked for.

    ``given``: what ``given_again`` says.
    """
    from sensorless.evaluation.evaluate import WORST
    from sensorless.evaluation.results import COLUMNS, HANDOVER_COLUMNS
    from sensorless.evaluation.results_tables import (
        lock_table,
        machines_table,
        paired_table,
        place_table,
        worst_table,
    )

    console.print(results.table())
    if machines:
        console.print(machines_table(results))
    if details:
        console.print(results.table(HANDOVER_COLUMNS))
        for columns in (COLUMNS, HANDOVER_COLUMNS) if results.paired else ():
            console.print(paired_table(results, columns))
        for name, entry in results.policies.items():
            console.print(place_table(name, entry))
    for table in (worst_table(results, WORST if details else 3, given), lock_table(results)):
        if table is not None:
            console.print(table)

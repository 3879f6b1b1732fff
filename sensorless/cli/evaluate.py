"""The command ``sensorless evaluate``."""

from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    EngineOption,
    MotorOption,
    RayAddressOption,
    SetOption,
    console,
    policy_progress,
)
from sensorless.errors import UserError


def list_policies(wanted: bool) -> None:
    """Print every policy with one line about it, and end."""
    if not wanted:
        return
    from sensorless.policies.registry import known

    lines = known()
    width = max(map(len, lines))
    for name, doc in lines.items():
        console.print(f"{name:{width}}  {doc}", markup=False, highlight=False, soft_wrap=True)
    raise typer.Exit


ListOption = Annotated[
    bool, typer.Option("--list", help="Name all policies.", is_eager=True, callback=list_policies)
]
PolicyOption = Annotated[
    list[str],
    typer.Option(
        "--policy",
        help="Rule by name (see evaluate --list), file of sensorless tune, or folder of a training "
        "run; repeatable.",
    ),
]


def evaluate_command(
    policy: PolicyOption,
    motor: MotorOption = "paper",
    suite: Annotated[
        str, typer.Option(help="paper, nominal, handoff, stress, envelope, motors or starts.")
    ] = "stress",
    seed: Annotated[int, typer.Option(min=0, help="Draws the scenarios.")] = 1,
    size: Annotated[int, typer.Option(min=1, help="Number of scenarios.")] = 200,
    settings: SetOption = None,
    out: Annotated[Path | None, typer.Option(help="Results as JSON.")] = None,
    every: Annotated[
        bool, typer.Option("--scenarios/--no-scenarios", help="Every single scenario in the JSON.")
    ] = True,
    details: Annotated[
        bool,
        typer.Option(
            "--details", help="Also print hand-over, pairs, quadrants, speeds, ten worst cases."
        ),
    ] = False,
    plot: Annotated[
        Path | None, typer.Option(help="PNG of what holds lock; with --suite envelope.")
    ] = None,
    engine: EngineOption = "local",
    ray_address: RayAddressOption = None,
    listed: ListOption = False,
) -> None:
    """Judge policies on a suite: lost rates, torque, speed and angle, with 95 % intervals.

    The same suite, seed and size give the same file to the bit, on any engine. Training and tuning
    never see these scenarios. Every policy is compared with the first one, pair by pair. The
    worst cases of each are listed with a word that `sensorless simulate --scenario` replays.
    A schedule runs on the estimator it was trained or tuned on, whatever `--set estimator` says
    (here and in every command that takes one); other rules run on the design's.
    """
    from sensorless.design.words import design_from
    from sensorless.evaluation.engines.named import engine_named
    from sensorless.evaluation.evaluate import WORST
    from sensorless.evaluation.evaluate import evaluate as run
    from sensorless.evaluation.results import COLUMNS, HANDOVER_COLUMNS
    from sensorless.evaluation.results_tables import paired_table, place_table, worst_table
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policies

    check_writable(plot, "plot")
    if plot is not None and suite != "envelope":
        raise UserError(f"plot: with suite {suite!r}; allowed: with --suite envelope")
    machine = Motor.load(motor)
    with engine_named(engine, ray_address) as where, policy_progress() as report:
        results = run(
            machine,
            design_from(settings),
            suite,
            seed,
            size,
            make_policies(policy, machine),
            out=out,
            every=every,
            progress=report,
            engine=where,
        )
    if plot is not None:
        from sensorless.plots.envelope import envelope_maps
        from sensorless.plots.figure import save

        save(envelope_maps(results, machine), plot)
    console.print(results.table())
    if details:
        console.print(results.table(HANDOVER_COLUMNS))
        for columns in (COLUMNS, HANDOVER_COLUMNS) if results.paired else ():
            console.print(paired_table(results, columns))
        for name, entry in results.policies.items():
            console.print(place_table(name, entry))
    console.print(worst_table(results, WORST if details else 3))
    for path in filter(None, (plot, out)):
        console.print(f"wrote {path}")

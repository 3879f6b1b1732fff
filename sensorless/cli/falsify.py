"""The command ``sensorless falsify``."""

from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.certify import PolicyArgument
from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    SeedOption,
    SetOption,
    bench_of,
    console,
    errors,
    say_json,
    say_wrote,
)


def falsify_command(
    policy: PolicyArgument,
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Write what was found here.")],
    motor: CarriedMotorOption = None,
    suite: Annotated[
        str,
        typer.Option(
            metavar="SUITE",
            help="Draw from the ranges of this suite: stress, stress-1, mismatch, low-inertia, or "
            "machines: stress-1 on random machines, one search on each.",
        ),
    ] = "stress",
    seed: SeedOption = 1,
    size: Annotated[
        int, typer.Option(metavar="N", min=128, help="Run at most this many scenarios.")
    ] = 20_000,
    settings: SetOption = None,
    override: OverrideOption = False,
    as_json: JsonOption = False,
) -> None:
    """Search for scenarios that a policy loses or nearly loses, inside the ranges of a suite.

    Many searches by CMA-ES, each from the worst of 128 random scenarios, move towards larger angle
    errors. The file has the worst scenario of each search. If it was lost, the file also says which
    of its deviations from nominal the loss needs. Ctrl-C keeps the searches that have ended.
    `sensorless simulate --scenario FILE.json:INDEX` draws the scenario, `FILE.json:INDEX:min` the
    same with all other numbers nominal.

    For example:

        sensorless falsify eq25 --set estimator=smo --out finds.json
        sensorless simulate --policy eq25 --set estimator=smo --scenario finds.json:0
    """
    from sensorless.envs.scenarios.finds import REMOVABLE, SEARCHED, require_finds, text_of
    from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
    from sensorless.envs.scenarios.machines_suite import refuse_motor
    from sensorless.envs.scenarios.scenario import SimFactory
    from sensorless.errors import UserError
    from sensorless.falsify.machines import search_machines
    from sensorless.falsify.minimise import minimise
    from sensorless.falsify.search import Search, search
    from sensorless.files import check_writable, write_atomic
    from sensorless.versions import versions

    check_writable(out, ending=".json")
    if out.is_file():
        require_finds(out)
    if suite not in (*SEARCHED, MACHINES):
        raise UserError(
            f"suite: {suite!r} cannot be searched; choose from {', '.join(SEARCHED)}, {MACHINES}"
        )
    refuse_motor(suite, motor)
    made = bench_of([policy], motor, settings, override)
    rule = made.policy(policy)

    def report(found: Search) -> None:
        errors.print(
            f"{found.scenarios} of {size} scenarios, {found.lost} lost; searches: {found.searches}",
            highlight=False,
        )

    if suite == MACHINES:
        found, lost = search_machines(
            lambda own: made.on(own).policy(policy), made.design, seed, size, report
        )
    else:
        factory = SimFactory(made.motor, made.design)
        found = search(rule, factory, suite, seed, size, report)
        lost = minimise(rule, factory, found.finds)
    kept = sorted(
        (find for find in found.finds if find.lost_at is None), key=lambda find: -find.severity
    )
    name = made.motor.name if suite != MACHINES else "random machines"
    facts = {
        "policy": rule.name, "suite": suite, "seed": seed, "motor": name,
        "estimator": made.design.estimator, "scenarios": found.scenarios, "lost": found.lost,
        "sampled": found.sampled, "sampled_lost": found.sampled_lost,
        "searches": found.searches, "versions": versions(),
    }  # fmt: skip
    write_atomic(out, text_of([*lost, *kept], facts))
    console.print(
        f"{rule.name} on {suite}: searches that end in a loss: {len(lost)} of {found.searches}; "
        f"{found.lost} of {found.scenarios} scenarios lost, "
        f"{found.sampled_lost} of {found.sampled} at random",
        highlight=False,
        soft_wrap=True,
    )
    for i, find in enumerate(lost[:5]):
        needs = [name for name in REMOVABLE if name not in find.nominal]
        console.print(
            f"{out}:{i}: lost at {find.lost_at:.3f} s; needs {', '.join(needs) or 'no deviation'}",
            highlight=False,
            soft_wrap=True,
        )
    if kept:
        console.print(
            f"{out}:{len(lost)}: keeps lock; largest angle error {kept[0].severity:.0f} degrees",
            highlight=False,
            soft_wrap=True,
        )
    if as_json:
        say_json({**facts, "file": str(out), "finds": len(lost) + len(kept)})
    say_wrote(out)
    if found.interrupted:
        errors.print(f"interrupted after {found.scenarios} of {size} scenarios", highlight=False)
        raise typer.Exit(130)

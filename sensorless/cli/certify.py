"""The command ``sensorless certify``."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sensorless.cli.evaluate import SuiteOption
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
    errors,
    say_json,
    say_wrote,
)

if TYPE_CHECKING:
    from sensorless.evaluation.certificate import Tally

OFTEN = {True: 1.0, False: 60.0}
"""Time between two lines on what is counted, on a terminal and elsewhere [s]."""
PolicyArgument = Annotated[
    str, typer.Argument(metavar="POLICY", help=f"Judge this policy: {POLICIES}.")
]


def say_progress(size: int) -> "Callable[[Tally, float], None]":
    """Print what is counted so far, from time to time."""
    said, begun = 0.0, -1

    def report(tally: "Tally", time: float) -> None:
        nonlocal said, begun
        begun = tally.scenarios if begun < 0 else begun
        if time - said < OFTEN[errors.is_terminal]:
            return
        said, pace = time, (tally.scenarios - begun) / time
        left = f", {(size - tally.scenarios) / pace / 60.0:.1f} minutes to go" if pace else ""
        errors.print(
            f"{tally.scenarios} of {size}: {tally.lost} lost, {tally.not_held} not held{left}",
            end="\r" if errors.is_terminal else "\n",
            highlight=False,
        )

    return report


def certify_command(
    policy: PolicyArgument,
    motor: CarriedMotorOption = None,
    suite: SuiteOption = "stress",
    seed: SeedOption = 1,
    size: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=1,
            help="Run this many scenarios; machines has 16 on each of its machines.",
        ),
    ] = 1_000_000,
    settings: SetOption = None,
    override: OverrideOption = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Write the result as JSON, and the state every 20 s. Rerun the command to "
            "resume, also with a larger size. Default: no file.",
        ),
    ] = None,
    engine: EngineOption = "local",
    ray_address: RayAddressOption = None,
    as_json: JsonOption = False,
) -> None:
    """Count how many of a million scenarios a policy loses or does not hold, and nothing else.

    The intervals are exact (Clopper and Pearson, 95 %): none lost of a million feasible scenarios
    means a rate of at most 3.7e-6. On machines they take the 16 scenarios of a machine for
    independent, so they are too narrow where losses gather on a few. What lost and held mean is as
    in `sensorless evaluate`. The same suite, seed and size give the same counts on any engine.
    `sensorless simulate --scenario` replays any lost scenario that the result names.

    For example:

        sensorless certify eq25 --size 20000
        sensorless certify reference --suite stress --out reference.json
    """
    from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
    from sensorless.envs.scenarios.machines_suite import refuse_motor
    from sensorless.evaluation.certify import certify, certify_machines
    from sensorless.evaluation.engines.named import engine_named

    refuse_motor(suite, motor)
    made = bench_of([policy], motor, settings, override)
    with engine_named(engine, ray_address) as where:
        common: dict[str, Any] = {
            "out": out,
            "engine": where,
            "progress": say_progress(size),
        }
        try:
            if suite == MACHINES:
                found = certify_machines(
                    lambda own: made.on(own).policy(policy), made.design, seed, size, **common
                )
            else:
                found = certify(
                    made.policy(policy), made.motor, made.design, suite, seed, size, **common
                )
        except KeyboardInterrupt:
            if out is not None and out.is_file():
                errors.print(f"{out} has what is done; rerun the command to go on")
            raise
    feasible = found["scenarios"] - found["infeasible"]
    console.print(
        f"{found['policy']} on {suite}, seed {seed}, motor {found['motor']}: "
        f"{found['scenarios']} scenarios, {found['infeasible']} not feasible",
        highlight=False,
    )
    apart = ", if a machine's scenarios were independent" if suite == MACHINES else ""
    for count, word in (("lost", "lost"), ("not_held", "not held")):
        low, high = found[f"{count}_ci"]
        some = ", ".join(found[f"first_{count}"][:3])
        console.print(
            f"{word}: {found[count]} of {feasible}, "
            f"{100.0 * low:.2g} to {100.0 * high:.2g} % (95 %, Clopper-Pearson{apart})"
            + (f"; {some}" if some else ""),
            highlight=False,
            soft_wrap=True,
        )
    if as_json:
        say_json(found)
    say_wrote(out)

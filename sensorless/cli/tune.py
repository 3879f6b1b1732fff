"""The command ``sensorless tune``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sensorless.cli.options import (
    EngineOption,
    JsonOption,
    MotorOption,
    RayAddressOption,
    SearchSeedOption,
    SetOption,
    console,
    describe,
    errors,
    minutely,
    say_if_unsuited,
    say_json,
    say_verdict,
    say_wrote,
    search_progress,
)

if TYPE_CHECKING:
    from sensorless.evaluation.objective import Cost


def tune_command(
    name: Annotated[
        str,
        typer.Argument(
            metavar="RULE",
            help="Tune this rule; `sensorless evaluate --list` names all rules, and those with "
            "numbers after a colon can be tuned. Given with numbers, such as linear:200,500, the "
            "search starts from them.",
        ),
    ],
    out: Annotated[Path, typer.Option(metavar="FILE.json", help="Write the tuned rule here.")],
    budget: Annotated[
        float, typer.Option(help="Simulate at most this much time of a drive [s].")
    ] = 20000.0,
    seed: SearchSeedOption = 1,
    motor: MotorOption = "paper",
    machines: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=0,
            help="Tune over this many random machines, drawn from the seed, instead of the motor; "
            "0 tunes for the motor alone.",
        ),
    ] = 0,
    settings: SetOption = None,
    engine: EngineOption = "local",
    ray_address: RayAddressOption = None,
    as_json: JsonOption = False,
) -> None:
    """Tune the numbers of a hand-over rule with CMA-ES, an evolutionary search.

    It minimises 10 lost_rate + torque deviation + torque ripple on scenarios of the suite stress-1,
    plus ten times a measure of how near half as many scenarios of unload come to a loss. Training
    and evaluation see none of these scenarios. The same command gives the same file, on any engine.
    Ctrl-C keeps the best rule found so far. The last line says whether the rule is better than its
    start on 400 scenarios of stress-1 that tuning has not seen. `sensorless tune gains` tunes the
    drive itself.

    For example:

        sensorless tune linear --budget 20000 --out linear-tuned.json
        sensorless evaluate --policy eq25 --policy linear-tuned.json
    """
    from sensorless.design.words import design_from
    from sensorless.evaluation.engines.named import engine_named
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.tuning.judge import judged
    from sensorless.tuning.tune import tune
    from sensorless.versions import typed

    check_writable(out, ending=".json")
    machine, design = Motor.load(motor), design_from(settings)
    if not machines:
        say_if_unsuited(machine, design)
    bar = search_progress(f"tuning {name.partition(':')[0]}")
    task = bar.add_task("", total=1.0)
    say = minutely()

    def report(done: float, best: "Cost") -> None:
        bar.update(task, completed=done, description=f"best: {describe(vars(best))}")
        say(f"{100.0 * done:.0f} %, best: {describe(vars(best))}")

    with engine_named(engine, ray_address) as where, bar:
        found = tune(
            name,
            machine,
            design,
            budget,
            seed,
            machines=machines,
            command=typed(),
            progress=report,
            engine=where,
        )
    found.save(out)
    known = found.provenance
    for label in ("start", "best"):
        console.print(f"{label:5}: {describe(known[label])}", highlight=False)
    console.print(f"policy: {known['policy']}", highlight=False, soft_wrap=True)
    say_wrote(out)
    if not known["interrupted"]:
        found = judged(found, machine, design, machines, seed)
        found.save(out)
        say_verdict(found.provenance["verdict"]["verdict"])
        if as_json:
            say_json({"rule": found.rule, "parameters": found.parameters, **found.provenance})
    else:
        errors.print(f"interrupted after {known['used_s']:g} s of {budget:g} s simulated")
        raise typer.Exit(130)

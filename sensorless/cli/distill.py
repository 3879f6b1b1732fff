"""The command ``sensorless distill``."""

import json
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.options import (
    JsonOption,
    SeedOption,
    console,
    describe,
    errors,
    say_json,
)
from sensorless.errors import UserError


def distill_command(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN",
            help="Take the network of this training run, made with --policy-kind mlp.",
        ),
    ],
    name: Annotated[str, typer.Option(help="Write the table to this new folder below runs/.")],
    axes: Annotated[
        str,
        typer.Option(
            metavar="AXES",
            help="Give the table these axes, SIGNAL:LOW:HIGH:NODES,..., for example speed:0:1:16; "
            "`start` takes the axes of "
            "the table that the network's training started from.",
        ),
    ] = "start",
    rounds: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=1,
            help="Fit this many times, each time on more states; the best table is kept.",
        ),
    ] = 4,
    size: Annotated[
        int,
        typer.Option(
            metavar="N", min=1, help="Visit this many scenarios of the suite stress-1 per round."
        ),
    ] = 256,
    seed: SeedOption = 1,
    smoothness: Annotated[
        float,
        typer.Option(
            metavar="<float>",
            min=0.0,
            help="Smooth the table: weight of its squared second differences against the squared "
            "error of the fit.",
        ),
    ] = 1e-3,
    validate_size: Annotated[
        int,
        typer.Option(
            metavar="N",
            min=16,
            help="Judge each table on this many other scenarios of the suite stress-1.",
        ),
    ] = 512,
    as_json: JsonOption = False,
) -> None:
    """Turn a trained network into a schedule table, which can be exported.

    The table is fitted to the network's decisions in the states that the table itself visits. The
    new folder holds the table and how far it falls short of the network. The same command gives
    the same table.

    For example:

        sensorless train --policy-kind mlp --name net
        sensorless distill runs/net --name net-table
    """
    from sensorless.agents.distill import distill
    from sensorless.agents.loading import CONFIG, TABLE, load_run
    from sensorless.agents.mlp.schedule import MlpSchedule
    from sensorless.agents.table.start import grid
    from sensorless.agents.train.run_folder import LIBRARIES, design_and_motor, fresh
    from sensorless.cli.train import RUNS
    from sensorless.design.carried import record
    from sensorless.envs.counter_random import check_seed
    from sensorless.envs.scenarios.scenario import SimFactory
    from sensorless.evaluation.objective import Cost
    from sensorless.files import write_atomic
    from sensorless.versions import versions

    check_seed(seed)
    design, motor = design_and_motor(run)
    teacher = load_run(run, motor)
    if not isinstance(teacher, MlpSchedule):
        raise UserError(
            f"run: {str(run)!r} already is a table; distill a run made with --policy-kind mlp"
        )
    folder, shape = RUNS / name, teacher.start.axes if axes == "start" else grid(axes)

    def report(number: int, rms: float, cost: Cost) -> None:
        errors.print(
            f"round {number} of {rounds}: k_s differs by {rms:.4f} RMS, {describe(vars(cost))}",
            highlight=False,
        )

    settings = {"rounds": rounds, "size": size, "seed": seed, "smoothness": smoothness}
    with fresh(folder):
        found = distill(
            teacher,
            shape,
            SimFactory(motor, design),
            rounds=rounds,
            size=size,
            seed=seed,
            smoothness=smoothness,
            validate_size=validate_size,
            report=report,
        )
        facts = {
            "command": shlex.join(["sensorless", *sys.argv[1:]]),
            "motor": motor.name,
            "motor_digest": motor.digest,
            **record(design, motor),
            "versions": versions(LIBRARIES),
            "distilled_from": {
                key: teacher.provenance.get(key) for key in ("command", "seed", "steps")
            },
            "settings": {**settings, "axes": axes, "validate_size": validate_size},
        }
        write_atomic(folder / CONFIG, json.dumps(facts, indent=1) + "\n")
        found.table.save(folder / TABLE, {**facts, **found.facts()})
    console.print(
        f"network: {describe(vars(found.network))}\ntable:   {describe(vars(found.cost))}",
        highlight=False,
    )
    if as_json:
        say_json({"table": str(folder / TABLE), **found.facts()})
    console.print(f"k_s differs by {found.rms:.4f} RMS\nwrote {folder / TABLE}", highlight=False)

"""The command ``sensorless distill``."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sensorless.cli.options import (
    JsonOption,
    SeedOption,
    console,
    describe,
    errors,
    say_json,
    say_wrote,
)
from sensorless.errors import UserError

if TYPE_CHECKING:
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor
    from sensorless.policy import Policy
    from sensorless.table.ks_table import Axis


def distill_command(
    run: Annotated[
        str,
        typer.Argument(
            metavar="RUN|MODULE:NAME",
            help="Take the network of this training run, made with --policy-kind mlp, or your own "
            "policy in Python, for the motor paper.",
        ),
    ],
    name: Annotated[str, typer.Option(help="Write the table to this new folder below runs/.")],
    axes: Annotated[
        str,
        typer.Option(
            metavar="AXES",
            help="Give the table these axes, SIGNAL:LOW:HIGH:NODES,..., for example speed:0:1:16; "
            "`start` takes the axes of "
            "the table that the network's training started from; a policy in Python has none.",
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
    the same table. A policy in Python in the place of the network must set k_s alone, from the
    signals of the moment.

    For example:

        sensorless train --policy-kind mlp --name net
        sensorless distill runs/net --name net-table
        sensorless distill own:Policy --name own-table --axes speed:0:1:16
    """
    from sensorless.agents.distill import distill
    from sensorless.agents.loading import CONFIG, TABLE
    from sensorless.agents.table.start import grid
    from sensorless.agents.train.run_folder import LIBRARIES, fresh
    from sensorless.cli.train import named_run
    from sensorless.design.carried import record
    from sensorless.envs.counter_random import check_seed
    from sensorless.envs.scenarios.scenario import SimFactory
    from sensorless.evaluation.objective import Cost
    from sensorless.files import write_atomic
    from sensorless.versions import typed, versions

    check_seed(seed)
    folder = named_run(name)
    teacher, design, motor, known, origin = _teacher(run)
    if axes == "start" and known is None:
        raise UserError(
            f"axes: start: {run!r} is a policy in Python and starts from no table; give --axes, "
            "for example speed:0:1:16"
        )
    shape = known if known is not None and axes == "start" else grid(axes)

    def report(number: int, rms: float, cost: Cost) -> None:
        errors.print(
            f"round {number} of {rounds}: k_s differs by {rms:.4f} RMS, {describe(vars(cost))}",
            highlight=False,
        )

    settings = {"rounds": rounds, "size": size, "seed": seed, "smoothness": smoothness}
    with fresh(folder, resumes=False):
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
            "command": typed(),
            "motor": motor.name,
            "motor_digest": motor.digest,
            **record(design, motor),
            "versions": versions(LIBRARIES),
            "distilled_from": origin,
            "settings": {**settings, "axes": axes, "validate_size": validate_size},
        }
        write_atomic(folder / CONFIG, json.dumps(facts, indent=1) + "\n")
        found.table.save(folder / TABLE, {**facts, **found.facts()})
    console.print(
        f"{teacher.name}: {describe(vars(found.network))}\ntable: {describe(vars(found.cost))}",
        highlight=False,
    )
    if as_json:
        say_json({"table": str(folder / TABLE), **found.facts()})
    console.print(f"k_s differs by {found.rms:.4f} RMS", highlight=False)
    say_wrote(folder / TABLE)


def _teacher(
    word: str,
) -> "tuple[Policy, DriveDesign, Motor, tuple[Axis, ...] | None, dict[str, Any]]":
    """Policy to distill, its drive and machine, the axes of its start, and where it comes from.

    Raises
    ------
    UserError
        It is no network and no policy in Python, or it sets gains or has a memory.
    """
    from sensorless.agents.distill import refuse_memory
    from sensorless.agents.loading import load_run
    from sensorless.agents.mlp.schedule import MlpSchedule
    from sensorless.agents.train.run_folder import design_and_motor
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor
    from sensorless.policies.bench import DEFAULT_MOTOR
    from sensorless.policies.python import is_python, python_policy
    from sensorless.policy import design_for, gains_of

    if is_python(word):
        motor = Motor.load(DEFAULT_MOTOR)
        own = python_policy(word, motor)
        if gains_of(own):
            raise UserError(f"run: {word!r} sets gains; distill a policy that sets k_s alone")
        refuse_memory(own)
        return own, design_for(own, DriveDesign()), motor, None, {"policy": word}
    design, motor = design_and_motor(Path(word))
    teacher = load_run(word, motor)
    if not isinstance(teacher, MlpSchedule):
        raise UserError(f"run: {word!r} already is a table; distill a run of --policy-kind mlp")
    origin = {key: teacher.provenance.get(key) for key in ("command", "seed", "steps")}
    return teacher, design, motor, teacher.start.axes, origin

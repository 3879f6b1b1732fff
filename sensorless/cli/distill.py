"""The command ``sensorless distill``."""

import dataclasses
import json
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from sensorless.errors import UserError

console = Console()
errors = Console(stderr=True)


def distill_command(
    run: Annotated[Path, typer.Argument(help="Folder of a run with --policy-kind mlp.")],
    name: Annotated[str, typer.Option(help="Run folder below runs/ for the table.")],
    axes: Annotated[
        str, typer.Option(help="SIGNAL:LOW:HIGH:NODES,... of the table; start: those of the start.")
    ] = "start",
    rounds: Annotated[int, typer.Option(min=1, help="Fits, each on more states.")] = 4,
    size: Annotated[int, typer.Option(min=1, help="Scenarios of a round.")] = 256,
    seed: Annotated[int, typer.Option(min=0, help="Draws the scenarios.")] = 1,
    smoothness: Annotated[
        float, typer.Option(min=0.0, help="Weight of the table's second differences.")
    ] = 1e-3,
    validate_size: Annotated[int, typer.Option(min=16, help="Scenarios of a validation.")] = 512,
) -> None:
    """Turn a trained network into a schedule table that can be exported.

    Fitted on states that the table itself visits. The new folder has the table and what it lost
    against the network; the same words give the same table.

        sensorless train --policy-kind mlp --name net

        sensorless distill runs/net --name net-table
    """
    from sensorless.agents.distill import distill
    from sensorless.agents.loading import CONFIG, TABLE, load_run
    from sensorless.agents.mlp.schedule import MlpSchedule
    from sensorless.agents.table.start import grid
    from sensorless.agents.train.run_folder import LIBRARIES, design_and_motor, fresh
    from sensorless.cli.train import RUNS
    from sensorless.envs.scenarios.scenario import SimFactory
    from sensorless.evaluation.objective import Cost
    from sensorless.files import write_atomic
    from sensorless.versions import versions

    design, motor = design_and_motor(run)
    teacher = load_run(run, motor)
    if not isinstance(teacher, MlpSchedule):
        raise UserError(f"run: {str(run)!r} has a table; allowed: a run with --policy-kind mlp")
    folder, shape = RUNS / name, teacher.start.axes if axes == "start" else grid(axes)
    fresh(folder)

    def report(number: int, rms: float, cost: Cost) -> None:
        errors.print(
            f"round {number} of {rounds}: k_s differs by {rms:.4f} RMS, {words(cost)}",
            highlight=False,
        )

    settings = {"rounds": rounds, "size": size, "seed": seed, "smoothness": smoothness}
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
        "design": dataclasses.asdict(design),
        "versions": versions(LIBRARIES),
        "distilled_from": {
            key: teacher.provenance.get(key) for key in ("command", "seed", "steps")
        },
        "settings": {**settings, "axes": axes, "validate_size": validate_size},
    }
    write_atomic(folder / CONFIG, json.dumps(facts, indent=1) + "\n")
    found.table.save(folder / TABLE, {**facts, **found.facts()})
    console.print(f"network: {words(found.network)}\ntable:   {words(found.cost)}", highlight=False)
    console.print(f"k_s differs by {found.rms:.4f} RMS\nwrote {folder / TABLE}", highlight=False)


def words(cost: object) -> str:
    """One line about a ``Cost``."""
    from sensorless.evaluation.objective import Cost

    assert isinstance(cost, Cost)
    return (
        f"lost {100 * cost.lost_rate:.1f} %, torque deviation {100 * cost.torque_dev:.2f} %, "
        f"ripple {100 * cost.torque_ripple:.2f} %"
    )

"""Whether a training run made its start better: the sentence it ends with."""

import json
from pathlib import Path
from shlex import quote

from sensorless.agents.loading import TABLE, VERDICT, load_run
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.run_folder import reopen, rows
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.compare import compare
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable


def judge(folder: Path) -> str:
    """Compare the best schedule of a run with its start, record it, and return the sentence.

    Both run on the machines and the drive of the run, in scenarios that it has not seen.

    Raises
    ------
    UserError
        No training run.
    """
    config, known, table = reopen(folder)
    motor = known.motor or Motor.load(config.motor)
    machines = Machines.of(motor, config.machines, config.seed)
    name = f"its start, {config.start}"
    if (folder / TABLE).is_file() and KsTable.load(folder / TABLE).digest == table.digest:
        sentence = _kept_start(folder, config, name)
        write_atomic(folder / VERDICT, json.dumps({"verdict": sentence}, indent=1) + "\n")
        return sentence
    best = load_run(folder, machines.motors[0])
    factories = [SimFactory(m, DriveDesign(**known.settings)) for m in machines.motors]
    found = compare(best, TablePolicy(config.start, table, best.settings), name, factories)
    write_atomic(folder / VERDICT, json.dumps(found.facts(), indent=1) + "\n")
    return found.sentence


def _kept_start(folder: Path, config: TrainConfig, name: str) -> str:
    """Why the schedule is still the start."""
    curve = rows(folder)
    values = [row["objective"] for row in curve]
    if len(set(values)) == 1:
        never, on = (
            f"the same as {name}: the run never moved",
            f"train --resume {quote(str(folder))}",
        )
        steps, first = curve[-1]["steps"], config.warm_up + 1
        least = first * config.n_envs * config.n_steps
        if steps <= least:
            return (
                f"{never}: it had {steps} decisions, and the table first moves after {least}, with "
                f"update {first} (warm_up = {config.warm_up}); go on with: sensorless {on}"
            )
        return (
            f"{never}, all {len(values)} validations are equal; go on with: sensorless {on}, or "
            "start a new run with larger --lr-nodes or --noise"
        )
    return (
        f"the same as {name}: the run moved, but none of {len(values)} validations was better than "
        "the first"
    )

"""Whether a training run made its start better: the sentence it ends with."""

import csv
import json
from pathlib import Path

from sensorless.agents.loading import TABLE, VERDICT, load_run
from sensorless.agents.train.run_folder import PROGRESS, reopen
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
        sentence = _kept_start(folder, name)
        write_atomic(folder / VERDICT, json.dumps({"verdict": sentence}, indent=1) + "\n")
        return sentence
    best = load_run(folder, machines.motors[0])
    factories = [SimFactory(m, DriveDesign(**known.settings)) for m in machines.motors]
    found = compare(best, TablePolicy(config.start, table, best.settings), name, factories)
    write_atomic(folder / VERDICT, json.dumps(found.facts(), indent=1) + "\n")
    return found.sentence


def _kept_start(folder: Path, name: str) -> str:
    """Why the schedule is still the start."""
    with (folder / PROGRESS).open(encoding="utf-8", newline="") as file:
        values = [row["objective"] for row in csv.DictReader(file)]
    if len(set(values)) == 1:
        return (
            f"the same as {name}: the run never moved, all {len(values)} validations are equal; "
            "train longer, or with larger --lr-nodes or --noise"
        )
    return (
        f"the same as {name}: the run moved, but none of {len(values)} validations was better than "
        "the first"
    )

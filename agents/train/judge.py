"""Whether a training run made its start better: the sentence it ends with."""

import json
import math
from pathlib import Path
from shlex import quote
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.save_util import load_from_zip_file

from sensorless.agents.loading import TABLE, VERDICT, load_run
from sensorless.agents.table.module import TableModule
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import rows
from sensorless.agents.train.run_folder import LATEST, reopen
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.compare import compare
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable

STEP = 1.0 / 32767.0
"""Step of a stored Q15 value: tables that differ by no more are the same."""


def judge(folder: Path) -> str:
    """Compare the best schedule of a run with its start, record it, and return the sentence.

    Both run on the machines and the drive of the run, in scenarios that it has not seen. A table
    that is still the start's at every node needs no scenario.

    Raises
    ------
    UserError
        No training run.
    """
    config, known, table = reopen(folder)
    motor = known.motor or Motor.load(config.motor)
    machines = Machines.of(motor, config.machines, config.seed)
    name = f"its start, {config.start}"
    if (folder / TABLE).is_file() and _apart(KsTable.load(folder / TABLE), table) <= STEP:
        sentence = f"the same as {name}: {_why_start(folder, config, table)}"
        write_atomic(folder / VERDICT, json.dumps({"verdict": sentence}, indent=1) + "\n")
        return sentence
    best = load_run(folder, machines.motors[0])
    factories = [SimFactory(m, DriveDesign(**known.settings)) for m in machines.motors]
    found = compare(best, TablePolicy(config.start, table, best.settings), name, factories)
    write_atomic(folder / VERDICT, json.dumps(found.facts(), indent=1) + "\n")
    return found.sentence


def _apart(ours: KsTable, theirs: KsTable) -> float:
    """Largest difference of k_s, or of the value of a gain, at a node; inf on other axes."""
    if ours.axes != theirs.axes:
        return math.inf
    grids = [(t.values, *(grid.values for grid in t.gains)) for t in (ours, theirs)]
    return max(float(np.max(np.abs(a - b))) for a, b in zip(*grids, strict=True))


def _why_start(folder: Path, config: TrainConfig, start: KsTable) -> str:
    """Why the schedule is still the start: what the weights did, not what they were worth."""
    curve = rows(folder)
    steps, first = curve[-1]["steps"], config.warm_up + 1
    least = first * config.n_envs * config.n_steps
    on = f"go on with: sensorless train --resume {quote(str(folder))}"
    if steps < least:
        return (
            f"the run never moved: it had {steps} decisions, and the table first moves after "
            f"{least}, with update {first} (--warm-up {config.warm_up}); {on}"
        )
    weights, k_s = _travel(folder, config, start)
    if weights <= STEP:
        return (
            f"the run never moved: in {steps} decisions no weight changed by more than "
            f"{weights:.1g}; {on}, or start a new run with a larger --lr-nodes or --noise"
        )
    if k_s <= STEP:
        return (
            f"the run never moved k_s: its weights changed by up to {weights:.1g}, but only beyond "
            f"0 and 1, where k_s is clipped; {on}, or start a new run with a larger --lr-nodes or "
            f"a smaller --margin than {config.margin:g}"
        )
    moved = f"the run's last weights move k_s by up to {k_s:.1g}"
    if config.last:
        return f"{moved}, but its last mean, of some {config.average} updates, is still the start"
    return f"{moved}, but none of {len(curve)} validations was better than that of the start"


def _travel(folder: Path, config: TrainConfig, start: KsTable) -> tuple[float, float]:
    """How far the last weights, and what the drive would have of them, are from the start's."""
    module = TableModule(start, config.margin)
    before = module.vector()
    _, saved, _ = load_from_zip_file(folder / LATEST, load_data=False, device="cpu")
    policy: dict[str, Any] = saved["policy"]  # type: ignore[assignment]
    module.load_state_dict(
        {k.removeprefix("actor."): x for k, x in policy.items() if k.startswith("actor.")}
    )
    weights = float(torch.max(torch.abs(module.vector() - before)))
    return weights, _apart(module.table(), start)

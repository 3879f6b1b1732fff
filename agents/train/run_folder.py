"""What a training run leaves on disk, and what it needs to resume."""

import dataclasses
import json
import sys
from pathlib import Path
from typing import Any

from sensorless.agents.loading import CONFIG, MLP, TABLE
from sensorless.agents.mlp.schedule import MlpSchedule
from sensorless.agents.train.config import TrainConfig
from sensorless.design.carried import Carried, carried, record
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.errors import UserError
from sensorless.files import ensure_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable
from sensorless.versions import versions

LIBRARIES = ("numpy", "torch", "stable-baselines3", "gymnasium")
"""What a trained schedule depends on."""
PROGRESS = "progress.csv"
START = "start.json"
"""File of the schedule that training started from."""
LATEST = "checkpoints/latest.zip"
ORIGIN = ("command", "motor", "motor_digest", "machines", "machine", "set", "design", "gains")
"""What a schedule takes over from the configuration of its run, beside ``versions``."""


def describe(
    config: TrainConfig, machines: Machines, design: DriveDesign, start: KsTable
) -> dict[str, Any]:
    """Content of ``config.json``."""
    return {
        "command": " ".join(["sensorless", *sys.argv[1:]]),
        **machines.origin(),
        "start_digest": start.digest,
        "train": dataclasses.asdict(config),
        **record(design, machines.one),
        "versions": versions(LIBRARIES),
    }


def create(
    folder: Path, config: TrainConfig, machines: Machines, design: DriveDesign, start: KsTable
) -> None:
    """Make a new run folder with its configuration and its start.

    Raises
    ------
    UserError
        The folder is not empty, or cannot be written to.
    """
    fresh(folder)
    ensure_writable(folder / "checkpoints")
    text = json.dumps(describe(config, machines, design, start), indent=1)
    write_atomic(folder / CONFIG, text + "\n")
    start.save(folder / START)


def fresh(folder: Path) -> None:
    """Make a new run folder.

    Raises
    ------
    UserError
        The folder is not empty, or cannot be written to.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(
            f"name: {str(folder)!r} already exists; choose a new name, or use --resume {folder}"
        )
    ensure_writable(folder)


def design_and_motor(folder: Path) -> tuple[DriveDesign, Motor]:
    """Return the design and the motor that a run was trained on.

    Raises
    ------
    UserError
        No run folder, one whose configuration cannot be read, or a run over several machines.
    """
    try:
        data = json.loads((folder / CONFIG).read_text(encoding="utf-8"))
        if "machines" in data:
            raise UserError(f"run: {folder}: trained on {data['motor']}; use a run on one motor")
        known = carried(data, str(folder / CONFIG))
        motor = known.motor or Motor.load(data["train"]["motor"])
        return DriveDesign(**known.settings), motor
    except (OSError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"run: {folder / CONFIG}: {error}; give a training run's folder") from None


def reopen(folder: Path) -> tuple[TrainConfig, Carried, KsTable]:
    """Configuration of a run to resume, its machine and drive, and its start table.

    Raises
    ------
    UserError
        No run folder, or one whose configuration cannot be read.
    """
    if not (folder / CONFIG).is_file() or not (folder / LATEST).is_file():
        raise UserError(
            f"resume: {str(folder)!r} has no {CONFIG} or no {LATEST}; give a training run's folder"
        )
    try:
        data = json.loads((folder / CONFIG).read_text(encoding="utf-8"))
        config, known = TrainConfig(**data["train"]), carried(data, str(folder / CONFIG))
        if config.machines:
            known = dataclasses.replace(known, made_for=(data["motor"], data["machines"]["digest"]))
        return config, known, KsTable.load(folder / START)
    except (ValueError, KeyError, TypeError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"{folder / CONFIG}: {error}; restore the file, or train anew") from None


def save_schedule(
    folder: Path, policy: TablePolicy | MlpSchedule, config: dict[str, Any], **facts: Any
) -> None:
    """Write the schedule with its provenance, under the name that ``load_run`` looks for."""
    origin = {key: config[key] for key in (*ORIGIN, "versions") if key in config}
    origin["seed"] = config["train"]["seed"]
    if isinstance(policy, TablePolicy):
        policy.table.save(folder / TABLE, {**origin, **facts})
    else:
        policy.save(folder / MLP, {**origin, **facts})

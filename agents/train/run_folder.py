"""What a training run leaves on disk, and what it needs to resume."""

import dataclasses
import json
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sensorless.agents.loading import CONFIG, MLP, TABLE, document
from sensorless.agents.mlp.schedule import MlpSchedule
from sensorless.agents.train.alone import alone
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import rows
from sensorless.design.carried import Carried, carried, record
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.errors import UserError, shown
from sensorless.files import ensure_writable, is_part, reason, remove, write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.settings import settings_of
from sensorless.table.ks_table import KsTable
from sensorless.versions import typed, versions

LIBRARIES = ("numpy", "torch", "stable-baselines3", "gymnasium")
"""What a trained schedule depends on."""
START = "start.json"
"""File of the schedule that training started from."""
LATEST = "checkpoints/latest.zip"
ORIGIN = (
    *("command", "resumed", "motor", "motor_digest", "machines", "machine"),
    *("set", "design", "gains"),
)
"""What a schedule takes over from the configuration of its run, beside ``versions``."""


def describe(
    config: TrainConfig, machines: Machines, design: DriveDesign, start: KsTable
) -> dict[str, Any]:
    """Content of ``config.json``."""
    return {
        "command": typed(),
        **machines.origin(),
        "start_digest": start.digest,
        "train": dataclasses.asdict(config),
        **record(design, machines.one),
        "versions": versions(LIBRARIES),
    }


def note_resumed(folder: Path, steps: int) -> None:
    """Add to the configuration of a run that it goes on, after how many decisions and by what.

    Such a run is not repeated by its first command, nor made by the versions of its start alone.

    Raises
    ------
    UserError
        The folder cannot be written to.
    """
    data = document(folder / CONFIG)
    before = data.get("resumed")
    here = {"steps": steps, "command": typed(), "versions": versions(LIBRARIES)}
    data["resumed"] = [*(before if isinstance(before, list) else []), here]
    write_atomic(folder / CONFIG, json.dumps(data, indent=1) + "\n")


def create(
    folder: Path, config: TrainConfig, machines: Machines, design: DriveDesign, start: KsTable
) -> None:
    """Write the configuration and the start of a run into its empty folder.

    Raises
    ------
    UserError
        The folder cannot be written to.
    """
    ensure_writable(folder / "checkpoints")
    text = json.dumps(describe(config, machines, design, start), indent=1)
    write_atomic(folder / CONFIG, text + "\n")
    start.save(folder / START)


@contextmanager
def fresh(folder: Path, resumes: bool = True) -> Iterator[None]:
    """Make a new run folder, or empty that of a run that ended before its first checkpoint.

    Nobody else can do so with the same folder meanwhile. ``resumes``: whether the command can go on
    with a run that is there.

    Raises
    ------
    UserError
        The folder holds anything else, is in use, or cannot be written to.
    """
    _refuse_run(folder, resumes)
    ensure_writable(folder)
    with alone(folder):
        _refuse_run(folder, resumes)  # another one may just have been here
        for path in list(folder.iterdir()):
            remove(path)
        yield


def _refuse_name(folder: Path, option: str) -> None:
    """TensorBoard's writer takes UTF-8 alone."""
    try:
        str(folder).encode()
    except UnicodeEncodeError:
        raise UserError(f"{option}: {str(folder)!r} is not UTF-8; choose another name") from None


def _refuse_run(folder: Path, resumes: bool) -> None:
    _refuse_name(folder, "name")
    try:
        if folder.exists() and not _barely_begun(folder):
            other = f", or use --resume {shlex.quote(str(folder))}" if resumes else ""
            raise UserError(f"name: {str(folder)!r} already exists; choose a new name{other}")
    except OSError as error:
        raise UserError(f"name: {str(folder)!r}: {reason(error)}; choose another name") from None


def _barely_begun(folder: Path) -> bool:
    """Whether a folder has nothing, or only what a run writes before its first schedule."""
    if not folder.is_dir():
        return False
    early = ("checkpoints", CONFIG, START, "tb")  # as they are written: else not of a run
    names = _whole(folder)
    return names == set(early[: len(names)]) and not _whole(folder / "checkpoints")


def _whole(folder: Path) -> set[str]:
    """Names in a folder, without what is half-written; none if there is no such folder."""
    if not folder.is_dir():
        return set()
    return {path.name for path in folder.iterdir() if not is_part(path.name)}


def design_and_motor(folder: Path) -> tuple[DriveDesign, Motor]:
    """Return the design and the motor that a run was trained on.

    Raises
    ------
    UserError
        No run folder, one whose configuration cannot be read, or a run over several machines.
    """
    path = folder / CONFIG
    if not path.is_file():
        raise UserError(f"run: {str(folder)!r} has no {CONFIG}; give a training run's folder")
    data = document(path)
    if "machines" in data:
        raise UserError(f"run: {folder}: trained on {data.get('motor')}; use a run on one motor")
    known = carried(data, str(path))
    motor = known.motor or Motor.load(setting_of(folder, "motor"))
    return DriveDesign(**known.settings), motor


def setting_of(folder: Path, name: str) -> Any:
    """Return a setting of ``TrainConfig`` that a run was trained with.

    Raises
    ------
    UserError
        Its configuration cannot be read or lacks it, or it is out of range.
    """
    path = folder / CONFIG
    values = _trained(document(path), path)
    if name not in values:
        raise UserError(f"{path}: train: {name}: missing; restore the file, or train anew")
    return settings_of(TrainConfig)[name].checked(values[name], f"{path}: train: ")


def _trained(data: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Return all settings of a run."""
    found = data.get("train")
    if not isinstance(found, dict):
        raise UserError(f"{path}: train: missing; restore the file, or train anew")
    return found


def reopen(folder: Path) -> tuple[TrainConfig, Carried, KsTable]:
    """Configuration of a run to resume, its machine and drive, and its start table.

    Raises
    ------
    UserError
        No run folder, or one whose configuration cannot be read.
    """
    _refuse_name(folder, "resume")
    begun = any(row["steps"] for row in rows(folder))
    needed = (CONFIG, START, LATEST) if begun else (CONFIG, START)
    missing = [name for name in needed if not (folder / name).is_file()]
    if missing:
        raise UserError(
            f"resume: {str(folder)!r} has no {missing[0]}; give a training run's folder, or train "
            "anew"
        )
    try:
        data = document(folder / CONFIG)
        config = _config(_trained(data, folder / CONFIG), folder / CONFIG)
        known = carried(data, str(folder / CONFIG))
        if config.machines:
            known = dataclasses.replace(known, made_for=(data["motor"], data["machines"]["digest"]))
        start = KsTable.load(folder / START)
    except (ValueError, KeyError, TypeError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"{folder / CONFIG}: {error}; restore the file, or train anew") from None
    if start.digest != data.get("start_digest"):
        raise UserError(
            f"{folder / START}: not the start of this run, digest {start.digest[:16]} instead of "
            f"{shown(str(data.get('start_digest'))[:16])}; restore the file, or train anew"
        )
    return config, known, start


def _config(found: Mapping[str, Any], path: Path) -> TrainConfig:
    """All settings of a run, each named as it is known today."""
    known = settings_of(TrainConfig)
    for what, names in (
        ("unknown", [name for name in found if name not in known]),
        ("missing", [name for name in known if name not in found]),
    ):
        if names:
            raise UserError(
                f"{path}: train: {names[0]}: {what}; restore the file, or train anew: another "
                "version may have made it"
            )
    try:
        return TrainConfig(**found)
    except UserError as error:
        raise UserError(f"{path}: train: {error}; restore the file, or train anew") from None


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

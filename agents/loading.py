"""Loads a trained schedule from its run folder, without pickle or torch."""

from pathlib import Path
from shlex import quote
from typing import Any

from sensorless.agents.mlp.schedule import MlpSchedule
from sensorless.design.carried import Carried, carried, refuse_other
from sensorless.errors import UserError, shown
from sensorless.files import as_text, read_json, reason
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable

TABLE, MLP, CONFIG, VERDICT = "table.json", "mlp.npz", "config.json", "verdict.json"


def load_run(
    folder: str | Path, motor: Motor, *, override: bool = False
) -> TablePolicy | MlpSchedule:
    """Return the policy of a run folder; it brings the settings that it was trained on.

    A schedule trained on one machine runs on that machine only, unless ``override``; one trained
    on random machines runs on any.

    Raises
    ------
    UserError
        The folder has no schedule, a file is damaged, or the schedule is for another machine.
    """
    policy, known = _schedule(Path(folder)), carried_by_run(folder)
    if not override:
        refuse_other(known, motor, f"run {str(folder)!r}")
    policy.settings = known.settings
    return policy


def load_table(path: Path, motor: Motor, *, override: bool = False) -> TablePolicy:
    """Return the policy of a table's file, such as that of an export; otherwise as ``load_run``."""
    table = KsTable.load(path)
    known = carried(table.provenance, str(path))
    if not override:
        refuse_other(known, motor, str(path))
    return TablePolicy(as_text(path.stem), table, known.settings)


def carried_by_run(folder: str | Path) -> Carried:
    """Machine and settings of a run: those of its schedule, or else of its configuration.

    Raises
    ------
    UserError
        As in ``load_run``.
    """
    path = Path(folder)
    known = provenance(_schedule(path))
    if not {"set", "design"} & set(known):
        known = {**_config(path), **known}
    return carried(known, str(path))


def _schedule(path: Path) -> TablePolicy | MlpSchedule:
    name = as_text(path.resolve().name)
    if (path / TABLE).is_file():
        return TablePolicy(name, KsTable.load(path / TABLE))
    if (path / MLP).is_file():
        return MlpSchedule.load(path / MLP, name)
    if (path / CONFIG).is_file():
        raise UserError(
            f"run: {str(path)!r} has no schedule yet; go on with: sensorless train --resume "
            f"{quote(str(path))}"
        )
    raise UserError(f"run: {str(path)!r} has no {TABLE} or {MLP}; give a training run's folder")


def _config(folder: Path) -> dict[str, Any]:
    """Settings of a run; empty if it has no such file."""
    path = folder / CONFIG
    return document(path) if path.is_file() else {}


def document(path: Path) -> dict[str, Any]:
    """Content of a JSON file of a run.

    Raises
    ------
    UserError
        It cannot be read, or has no fields.
    """
    try:
        data = read_json(path)
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: {reason(error)}; restore the file, or train anew") from None
    if not isinstance(data, dict):
        raise UserError(f"{path}: {shown(data)} has no fields; restore the file, or train anew")
    return data


def verdict_of(folder: Path) -> str | None:
    """Return the sentence that a run ended with; None: it has none, or the folder is no run.

    Raises
    ------
    UserError
        The file is damaged.
    """
    path = folder / VERDICT
    if not path.is_file():
        return None
    said = document(path).get("verdict")
    if not isinstance(said, str):
        raise UserError(f"{path}: verdict: {shown(said)} is no text; restore or remove the file")
    return said


def provenance(policy: TablePolicy | MlpSchedule) -> dict[str, Any]:
    """Where a schedule comes from."""
    return dict(policy.table.provenance if isinstance(policy, TablePolicy) else policy.provenance)

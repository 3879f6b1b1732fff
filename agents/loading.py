"""Loads a trained schedule from its run folder, without pickle or torch."""

import json
from pathlib import Path
from typing import Any

from sensorless.agents.mlp.schedule import MlpSchedule
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policy import UNRECORDED, TablePolicy, trained_estimator
from sensorless.table.ks_table import KsTable

TABLE, MLP, CONFIG = "table.json", "mlp.npz", "config.json"


def load_run(folder: str | Path, motor: Motor) -> TablePolicy | MlpSchedule:
    """Return the policy of a run folder; it runs on the estimator that it was trained on.

    A schedule trained on one machine runs on that machine only, one trained on random machines runs
    on any.

    Raises
    ------
    UserError
        The folder has no schedule, a file is damaged, or the schedule is for another machine.
    """
    path, name = Path(folder), Path(folder).resolve().name
    policy: TablePolicy | MlpSchedule
    if (path / TABLE).is_file():
        policy = TablePolicy(name, KsTable.load(path / TABLE))
    elif (path / MLP).is_file():
        policy = MlpSchedule.load(path / MLP, name)
    else:
        raise UserError(
            f"run: {str(folder)!r} has no {TABLE} or {MLP}; give a training run's folder"
        )
    known = provenance(policy)
    made_for = str(known.get("motor_digest", motor.digest))
    if made_for != motor.digest:
        raise UserError(
            f"run: {str(folder)!r} was trained on motor {known.get('motor', '?')!r}, "
            f"digest {made_for[:16]}; it cannot run on motor {motor.name!r}, digest "
            f"{motor.digest[:16]}: select its motor, or train anew"
        )
    recorded = trained_estimator(known) or trained_estimator(_config(path))
    policy.estimator = recorded or UNRECORDED
    return policy


def _config(folder: Path) -> dict[str, Any]:
    """Settings of a run; empty if it has no such file."""
    path = folder / CONFIG
    try:
        data = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: {error}; restore the file, or train anew") from None
    return data if isinstance(data, dict) else {}


def provenance(policy: TablePolicy | MlpSchedule) -> dict[str, Any]:
    """Where a schedule comes from."""
    return dict(policy.table.provenance if isinstance(policy, TablePolicy) else policy.provenance)

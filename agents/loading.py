"""A trained schedule from its run folder: no pickle, no torch."""

from pathlib import Path
from typing import Any

from sensorless.agents.mlp_schedule import MlpSchedule
from sensorless.envs.policy import TablePolicy
from sensorless.errors import UserError
from sensorless.ks_table import KsTable
from sensorless.motor import Motor

TABLE, MLP = "table.json", "mlp.npz"


def load_run(folder: str | Path, motor: Motor) -> TablePolicy | MlpSchedule:
    """Policy of a run folder, for the machine it was trained on; for any if those were random.

    Raises
    ------
    UserError
        No schedule in the folder, a damaged one, or one of another machine.
    """
    path, name = Path(folder), Path(folder).resolve().name
    policy: TablePolicy | MlpSchedule
    if (path / TABLE).is_file():
        policy = TablePolicy(name, KsTable.load(path / TABLE))
    elif (path / MLP).is_file():
        policy = MlpSchedule.load(path / MLP, name)
    else:
        raise UserError(
            f"run: {str(folder)!r}: no {TABLE} or {MLP} in it; allowed: a training run's folder"
        )
    known = provenance(policy)
    made_for = str(known.get("motor_digest", motor.digest))
    if made_for != motor.digest:
        raise UserError(
            f"run: {str(folder)!r} was trained on motor {known.get('motor', '?')!r}, "
            f"digest {made_for[:16]}; allowed: motor {motor.name!r}, digest "
            f"{motor.digest[:16]}"
        )
    return policy


def provenance(policy: TablePolicy | MlpSchedule) -> dict[str, Any]:
    """Where a schedule comes from."""
    return dict(policy.table.provenance if isinstance(policy, TablePolicy) else policy.provenance)

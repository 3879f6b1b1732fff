"""A trained schedule from its run folder: numbers as JSON, no pickle and no torch."""

from pathlib import Path

from sensorless.envs.policy import TablePolicy
from sensorless.errors import UserError
from sensorless.ks_table import KsTable
from sensorless.motor import Motor

TABLE = "table.json"


def load_run(folder: str | Path, motor: Motor) -> TablePolicy:
    """Policy of a run folder, for the machine it was trained on.

    Raises
    ------
    UserError
        No table in the folder, a damaged one, or one of another machine.
    """
    path = Path(folder) / TABLE
    if not path.is_file():
        raise UserError(f"run: {str(folder)!r}: no {TABLE} in it; allowed: a training run's folder")
    table = KsTable.load(path)
    made_for = table.provenance.get("motor_digest", motor.digest)
    if made_for != motor.digest:
        raise UserError(
            f"run: {str(folder)!r} was trained on motor {table.provenance.get('motor', '?')!r}, "
            f"digest {str(made_for)[:16]}; allowed: motor {motor.name!r}, digest "
            f"{motor.digest[:16]}"
        )
    return TablePolicy(Path(folder).resolve().name, table)

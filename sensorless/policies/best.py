"""The best schedule found for each shipped machine: the record of ``studies/best_schedules.py``."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sensorless.design.drive import DriveDesign
from sensorless.design.fingerprint import fingerprint
from sensorless.machine.motor import MOTORS, Motor

RECORD = MOTORS / "schedules.json"


@dataclass(frozen=True)
class Best:
    """One machine's entry."""

    policy: str
    """Word for ``--policy``."""
    verdict: str
    objection: str
    """Why `sensorless export` refuses it; empty if it does not."""
    fresh: bool
    """Machine and default drive are those it was found on."""


def identity(motor: Motor) -> dict[str, Any]:
    """What a schedule was found on: the machine, and the numbers of the default drive."""
    return {"digest": motor.digest, "gains": fingerprint(motor, DriveDesign())}


def best(motor: Motor, record: Path = RECORD) -> Best | None:
    """Entry of a machine, by its name; None if there is none."""
    if not record.is_file():
        return None
    found = json.loads(record.read_text(encoding="utf-8"))["machines"].get(motor.name)
    if found is None:
        return None
    objection = found["judged"]["objection"]
    return Best(found["policy"], found["verdict"], objection, found["on"] == identity(motor))

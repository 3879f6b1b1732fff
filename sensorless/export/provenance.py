"""Records where the numbers of an export come from."""

import hashlib
import importlib.metadata
from collections.abc import Mapping
from typing import Any

from sensorless.core.api import ffi, lib
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable

DISTRIBUTIONS = ("sensorless", "numpy", "torch", "stable-baselines3", "gymnasium")


def motor_hash(motor: Motor) -> int:
    """First 32 bits of the motor's digest, stored in both table and parameters."""
    return int(motor.digest[:8], 16)


def table_json(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    origin: Mapping[str, Any],
    files: Mapping[str, bytes],
) -> str:
    """``ks_table.json``: a file that ``KsTable.load`` reads.

    Parameters
    ----------
    table, motor, design
    origin : mapping
        What is known of the policy: name, training command, seed, ...
    files : mapping
        Every other file of the export by name.
    """
    tables = (
        ("f32", table.record("f32", motor_hash=motor_hash(motor))),
        ("q15", table.record("q15", motor_hash=motor_hash(motor))),
    )
    return table.to_json(
        {
            **origin,
            "table_digest": table.digest,
            "motor": motor.name,
            "motor_digest": motor.digest,
            **record(design, motor),
            "export": {
                "versions": {name: _version(name) for name in DISTRIBUTIONS},
                "core_hash": ffi.string(lib.core_hash).decode(),
                "crc": {
                    f"{form}_{part}": f"0x{int(t[f'crc_{part}']):08x}"
                    for form, t in tables
                    for part in ("header", "values")
                },
                "sha256": {
                    name: hashlib.sha256(content).hexdigest() for name, content in files.items()
                },
            },
        }
    )


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None

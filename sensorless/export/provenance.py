"""Records where the numbers of an export come from."""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from typing import Any

from sensorless.design.carried import chosen, commands_of, record, worded
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable
from sensorless.versions import versions

LIBRARIES = ("numpy", "torch", "stable-baselines3", "gymnasium")
"""Libraries that make a table."""


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
            "settings_digest": settings_digest(design),
            **record(design, motor),
            "export": {
                "versions": versions(LIBRARIES),
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


def provenance_text(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    origin: Mapping[str, Any],
    verdict: str,
) -> str:
    """``PROVENANCE.txt``: the same for people, who may keep it with a released firmware."""
    made = [f"  command: {text}" for text in commands_of(origin)]
    made += [f"  seed: {origin['seed']}"] if "seed" in origin else []
    settings = [f"  {name} = {value}" for name, value in chosen(design).items()]
    made_with = versions(LIBRARIES)
    return "\n".join(
        [
            f"Schedule: {origin['policy']}, SHA-256 {table.digest}",
            *made,
            f"Motor: {motor.name}, SHA-256 {motor.digest}",
            f"Settings: SHA-256 {settings_digest(design)}; chosen or other than the default:",
            *settings,
            f"Control core: SHA-256 {made_with.pop('core')}",
            "Made by sensorless export, with:",
            *(f"  {name} {version}" for name, version in made_with.items()),
            f"Verdict: {verdict}.",
            "",
            "ks_table.json has all numbers. sha256sum -c SHA256SUMS checks every file of this",
            "folder. LICENSE holds for all of them.",
            "",
        ]
    )


def settings_digest(design: DriveDesign) -> str:
    """SHA-256 of every setting of the drive, in JSON with sorted names."""
    text = json.dumps(worded(dataclasses.asdict(design)), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()

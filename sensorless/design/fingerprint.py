"""Fingerprints of the numbers that a drive runs on: whether its formulas have changed since."""

import hashlib
from collections.abc import Iterator

import numpy as np

from sensorless.core.api import Array
from sensorless.design.control import BRAKING
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor

OBSERVER = {"smo": "smo", "unwrapped": "smo", "errors": "smo", "flux": "flux", "coupled": "coupled"}
"""Part of ``drive_params_t`` that an estimator reads, by ``DriveDesign.estimator``."""
SHARED = {"flux": tuple(f"coupled.{name}" for name in ("R_s", "L_d", "psi_d", "psi_sq_min"))}
"""What it reads of another part: ``drive_flux_model``."""
LATER = {"control.by_reference", "control.i_q_brake"} | {
    f"coupled.{name}" for name in ("brake", "brake_least", "idle", "inv_i_idle", "match.alone")
}
"""Numbers that were added later and change nothing where they are 0: there they do not count."""
LITTLE = 1.001 * BRAKING
"""Share of ``i_max`` up to which ``i_q_brake`` does not count: it was 0 there once, and so little
changes only drives that brake with their d current at its end. Of the leaderboard's suites that is
`low-inertia`, by a percent on the default drive (docs/studies.md)."""
DAMAGE = {"control.i_int_max"}
"""Bounds that only a damaged state passes."""
DIGITS = 4
"""Of the numbers that count: other computers round the last ones otherwise."""


def fingerprint(motor: Motor, design: DriveDesign) -> dict[str, str]:
    """Eight hexadecimal digits of each part of a drive, by name; unused observers do not count."""
    record = control_record(motor, design)
    control = record["control"]
    if control["i_q_brake"] < LITTLE * control["i_max"]:
        control["i_q_brake"] = 0.0
    shared = SHARED.get(design.estimator, ())
    parts = {
        "injection": ("hfi",),
        "observer": (OBSERVER[design.estimator], *shared, "L_q", "theta_cross"),
        "control": ("control",),
        "signals": ("signal",),
    }
    return {
        part: hashlib.sha256(
            "\n".join(line for name in names for line in _lines(_part(record, name), name)).encode()
        ).hexdigest()[:8]
        for part, names in parts.items()
    }


def _part(record: Array, path: str) -> Array:
    """What stands at a path such as ``coupled.R_s``."""
    for name in path.split("."):
        record = record[name]
    return record


def _lines(record: Array, path: str) -> Iterator[str]:
    names = record.dtype.names
    if path in DAMAGE or (path in LATER and not record.any()):
        return
    if names is None:
        yield f"{path} " + " ".join(f"{x:.{DIGITS}g}" for x in np.ravel(record))
        return
    for name in names:
        yield from _lines(record[name], f"{path}.{name}")

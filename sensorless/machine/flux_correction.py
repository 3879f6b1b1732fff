"""Correction of the saturation model by a flux map: what the simulated machine has beyond it.

An energy over the flux plane, in splines; ``core/sim/flux_correction.h`` has the equations.
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.core.machine import CORRECTION, enter_correction
from sensorless.errors import UserError, shown
from sensorless.settings import REQUIRED, number, read

ROOM = np.zeros((), dtype=CORRECTION)["c"].shape
MOST = ROOM[0] - 6, ROOM[1] - 4
"""Most rows, and most numbers a row: the core has them with a border of zeros and images."""
LEAST = 4
"""Fewest of either."""
LARGEST = 1e6
"""Largest flux linkage [Vs] and energy [Vs A]: beyond any machine."""
NARROWEST = 1e-9
"""Least width of the grid [Vs]: below any machine, and its inverse is a number."""


@dataclass(frozen=True)
class FluxCorrection:
    """Spline coefficients of an energy over psi_d and the magnitude of psi_q."""

    psi_d_from: float = number(REQUIRED, "Vs", -LARGEST, LARGEST, "d flux where it begins")
    psi_d_to: float = number(REQUIRED, "Vs", -LARGEST, LARGEST, "d flux where it ends")
    psi_q_to: float = number(REQUIRED, "Vs", NARROWEST, LARGEST, "q flux where it ends")
    energy: tuple[tuple[float, ...], ...] = ()
    """(n_d, n_q) coefficients [Vs A], psi_d along the rows; 3/2 of them are joules."""

    @property
    def record(self) -> Array:
        """The C struct ``flux_correction_t``, shape (), not entered."""
        c = np.array(self.energy)
        n_d, n_q = c.shape
        record = np.zeros((), dtype=CORRECTION)
        record["psi_d0"], record["n_d"], record["n_q"] = self.psi_d_from, n_d + 3, n_q + 1
        record["inv_h_d"] = (n_d + 3) / (self.psi_d_to - self.psi_d_from)
        record["inv_h_q"] = (n_q + 1) / self.psi_q_to
        record["c"][3 : 3 + n_d, 1 : 1 + n_q] = c
        record["c"][3 : 3 + n_d, 0] = c[:, 1]
        return record


@lru_cache(maxsize=256)
def correction_key(correction: FluxCorrection) -> int:
    """What ``flux_map_t`` calls the correction by, entered into the core."""
    return enter_correction(correction.record)


def read_correction(table: object, where: str) -> FluxCorrection | None:
    """Correction from a table of a motor file; None: there is none.

    Raises
    ------
    UserError
        A field is missing, unknown or out of range; ``where`` opens the message.
    """
    if table is None:
        return None
    if not isinstance(table, dict):
        raise UserError(f"{where}: must be a table, got {shown(table)}")
    values = dict(table)
    energy = _rows(values.pop("energy", None), where)
    numbers: dict[str, Any] = read(FluxCorrection, values, f"{where}: ")
    if numbers["psi_d_to"] < numbers["psi_d_from"] + NARROWEST:
        raise UserError(
            f"{where}: psi_d_to: {numbers['psi_d_to']:g} Vs: must be above psi_d_from = "
            f"{numbers['psi_d_from']:g} Vs by at least {NARROWEST:g} Vs"
        )
    return FluxCorrection(**numbers, energy=energy)


def _rows(energy: object, where: str) -> tuple[tuple[float, ...], ...]:
    shape = f"{LEAST} to {MOST[0]} rows of {LEAST} to {MOST[1]} numbers"
    if not isinstance(energy, list | tuple):
        what = "missing" if energy is None else shown(energy)
        raise UserError(f"{where}: energy: {what}; give {shape}")
    if not LEAST <= len(energy) <= MOST[0]:
        raise UserError(f"{where}: energy: {len(energy)} rows; give {shape}")
    rows = []
    for j, row in enumerate(energy, start=1):
        if not isinstance(row, list | tuple):
            raise UserError(f"{where}: energy: row {j}: {shown(row)}; give {shape}")
        if len(row) != len(energy[0]) or not LEAST <= len(row) <= MOST[1]:
            raise UserError(
                f"{where}: energy: row {j}: {len(row)} numbers; give {shape}, all alike"
            )
        for value in row:
            good = isinstance(value, int | float) and not isinstance(value, bool)
            if not (good and abs(value) <= LARGEST):  # false for NaN
                raise UserError(
                    f"{where}: energy: row {j}: {shown(value)}; give numbers of at most "
                    f"{LARGEST:g} Vs A"
                )
        rows.append(tuple(float(value) for value in row))
    return tuple(rows)


def correction_table(correction: FluxCorrection) -> dict[str, Any]:
    """Table of a motor file."""
    return dataclasses.asdict(correction)


def rounded(correction: FluxCorrection) -> FluxCorrection:
    """The correction with six decimals of its largest coefficient."""
    largest = max(max(map(abs, row)) for row in correction.energy)
    digits = 6 - math.ceil(math.log10(largest)) if largest > 0.0 else 0
    energy = tuple(tuple(round(x, digits) for x in row) for row in correction.energy)
    return dataclasses.replace(correction, energy=energy)

"""Maps for a page: where lock holds over speed and load, and a table's weights."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.evaluation.results import Envelope, Results
from sensorless.machine.motor import Motor
from sensorless.plots.schedule import Sheet

BEYOND, LOST = -1, -2
"""In place of a value: the machine cannot do it, or lock is lost."""


@dataclass(frozen=True)
class Map:
    """Values over two axes."""

    title: str
    note: str
    x: tuple[float, float, str]
    """first, last, label"""
    y: tuple[float, float, str]
    values: Array
    """(rows, columns), the first row at the lowest y"""
    most: float
    """end of the colours"""
    unit: str
    decimals: int
    light: str = "least"
    """which end of the values has the lightest colour, least or most"""

    def packed(self) -> dict[str, Any]:
        """All of it in JSON types."""
        factor = 10**self.decimals
        whole = np.where(self.values < 0.0, self.values, np.rint(factor * self.values))
        return {
            "title": self.title, "x": self.x, "y": self.y, "columns": self.values.shape[1],
            "rows": self.values.shape[0], "values": whole.astype(int).ravel().tolist(),
            "factor": factor, "most": self.most, "unit": self.unit,
            "light": self.light,
        }  # fmt: skip


def envelope(results: Results, motor: Motor, most: float) -> list[Map]:
    """Angle error where each policy keeps lock."""
    out = []
    for name, policy in results.policies.items():
        found = Envelope.of(policy["scenarios"])
        values = np.where(found.lost, LOST, np.nan_to_num(found.error))
        values = np.where(found.beyond, BEYOND, values)
        able = ~found.beyond
        held = int(np.sum(~found.lost & able))
        out.append(
            Map(
                name, f"keeps lock in {held} of {int(np.sum(able))} points",
                (-motor.n_rated_rpm, motor.n_rated_rpm, "speed [r/min]"),
                (-motor.tau_rated, motor.tau_rated, "load [N m]"),
                values, most, "°", 1,
            )
        )  # fmt: skip
    return out


def schedule(sheets: list[Sheet]) -> list[Map]:
    """Weights of a table beside those of another one."""
    return [
        Map(
            s.title, s.note, (float(s.x[0]), float(s.x[-1]), s.x_label),
            (float(s.y[0]), float(s.y[-1]), s.y_label), s.k_s, 1.0, "", 2,
            light="most",
        )
        for s in sheets
    ]  # fmt: skip

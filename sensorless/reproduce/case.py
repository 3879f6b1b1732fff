"""The source paper's drive and ours, and the form in which a figure is set beside them.

The paper is doi 10.12177/emca.2025.011. Angles that are printed in its convention (estimate minus
truth) say so; everything else is truth minus estimate or a magnitude.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.observers.smo_design import deadbeat_gain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PUBLISHED = DriveDesign(
    hfi_pll_hz=20.0,
    smo_pll_hz=30.0,
    smo_gain=1.0,
    smo_cross_hz=math.inf,
    L_q_bias=1.0,
    speed_hz=3.0,
    lag_cure=False,
    L_q_table=False,
    cross="none",
    mtpa=False,
    hfi_scheme="stationary",
    hfi_delay_cure=False,
)
"""Eqs. 7 and 9, injection along the angle of the sample, sigmoid without lag cure, constant L_q, no
filter in the cross term, i_d = 0; bandwidths are not in the paper and were chosen."""

CORRECTED = DriveDesign()
"""The drive of this project."""

NOT_SWITCHABLE = (
    "the sign of the demodulation, lost in Eq. 7 as printed: without it there is no lock, with the "
    "wrong one a lock across the rotor; both have a queue of the signs that were applied",
    "the wrap that Eq. 26 lacks: the paper's angle errors were not measured without it; what it "
    "costs is the last section",
    "Eq. 25 for negative speed, where as printed it never leaves injection: all runs are forward",
    "the paper treats neither start, polarity, warm start of the idle observer, voltage limit nor "
    "the injection's switching: both columns have ours",
)
"""What the published column shares with the corrected one."""

SIGN_K = 400.0
"""Correction voltage of Fig. 12 [V], chosen; the EMF is 62 V at 300 r/min."""

Cell = float | str | bool | None


@dataclass(frozen=True)
class Row:
    """One quantity in three columns."""

    quantity: str
    unit: str
    paper: str
    published: Cell
    corrected: Cell
    decimals: int = 2

    def plain(self) -> dict[str, Any]:
        """Plain data for JSON; nothing where there is no finite number."""
        return {
            "unit": self.unit,
            "paper": self.paper,
            "published": _finite(self.published),
            "corrected": _finite(self.corrected),
        }


def row_of(quantity: str, unit: str, paper: str, cells: Sequence[Cell], decimals: int = 2) -> Row:
    """Row of two cells: published, corrected."""
    published, corrected = cells
    return Row(quantity, unit, paper, published, corrected, decimals)


@dataclass(frozen=True)
class Case:
    """A figure of the paper: numbers, why they differ, and a picture."""

    name: str
    title: str
    setting: str
    rows: tuple[Row, ...]
    why: str
    figure: "Figure | None" = field(default=None, compare=False)


def gain(motor: Motor, g: float) -> float:
    """``smo_gain`` of a design for the slope g = k a / 2 [V/A] at the origin."""
    return g / deadbeat_gain(motor)


def _finite(cell: Cell) -> Cell:
    return None if isinstance(cell, float) and not math.isfinite(cell) else cell

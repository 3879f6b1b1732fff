"""The source paper's drive and ours, and the form in which a figure is set beside them.

The paper is doi 10.12177/emca.2025.011. Angles that are printed in its convention (estimate minus
truth) say so; everything else is truth minus estimate or a magnitude.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from sensorless.core_api import Array
from sensorless.drive import DriveDesign
from sensorless.motor import Motor
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
)
"""As far as switches go: sigmoid without lag cure, constant L_q, no filter in the cross term,
i_d = 0; bandwidths are not in the paper and were chosen."""

CORRECTED = DriveDesign()
"""The drive of this project."""

NOT_SWITCHABLE = (
    "Eq. 9, the first difference in the stationary frame: ours is the second difference in the "
    "rotating estimate, whose timing error is 0 (theirs −0.5° at 350 r/min, −0.9° at 600)",
    "Eq. 7, whose demodulation has lost its sign and whose denominator holds at lock only: ours "
    "has a queue of signs and the exact magnitude, with the same slope at lock",
    "Eq. 15, which is not normalised: the loop gain would depend on voltage and inductances",
    "Eq. 26 without its wrap: the mean of 359° and 1° would be 180°",
    "Eq. 25 for negative speed, which as printed never leaves injection: ours takes the magnitude",
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


def fixed_k(sims: Array) -> None:
    """Change that sets the correction voltage to ``SIGN_K`` and keeps the gain at the origin."""
    smo = sims["control"]["smo"]
    smo["half_a"] *= smo["k"] / SIGN_K
    smo["k"] = SIGN_K


def gain(motor: Motor, g: float) -> float:
    """``smo_gain`` of a design for the slope g = k a / 2 [V/A] at the origin."""
    return g / deadbeat_gain(motor)


def _finite(cell: Cell) -> Cell:
    return None if isinstance(cell, float) and not math.isfinite(cell) else cell

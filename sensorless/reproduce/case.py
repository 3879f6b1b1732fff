"""Our drive as published and as corrected, and the rows that set both beside the paper's numbers.

The paper is doi 10.12177/emca.2025.011. Angles in its convention (estimate minus truth) say so; all
others are truth minus estimate or magnitudes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.plain_json import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PUBLISHED = DriveDesign(
    estimator="smo",
    hfi_pll_hz=20.0,
    smo_pll_hz=30.0,
    smo_gain=1.0,
    smo_cross_hz=math.inf,
    smo_floor_rpm=40.0,
    L_q_bias=1.0,
    L_q_motoring=1.0,
    speed_hz=3.0,
    current_hz=120.0,
    i_q_slew=150.0,
    lag_cure=False,
    L_q_table=False,
    cross="none",
    mtpa=False,
    hfi_scheme="stationary",
    hfi_delay_cure=False,
)
"""Eqs. 7 and 9, injection along the angle of the sample, sigmoid without lag cure, constant L_q, no
filter in the cross term, i_d = 0. The paper gives no bandwidths; these were chosen."""

CORRECTED = DriveDesign(estimator="smo")
"""The same two observers with the corrections of this project."""

NOT_SWITCHABLE = (
    "The sign of the demodulation, which Eq. 7 lacks in print: without it there is no lock, and "
    "with the wrong one the lock is across the rotor. Both columns keep a queue of the applied "
    "signs.",
    "The wrap, which Eq. 26 lacks: the paper's angle errors cannot have been measured without it. "
    "The last section shows what it costs to leave it out.",
    "Eq. 25 at negative speed, where in print it never leaves injection: all runs are forward.",
    "What the paper does not treat: start, polarity, warm start of the idle observer, voltage "
    "limit and the switching of the injection. Both columns have ours.",
)
"""What the published column shares with the corrected one, because no switch undoes it."""

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

    def facts(self) -> dict[str, Any]:
        """Return plain data for JSON; None where there is no finite number."""
        return {
            "unit": self.unit,
            "paper": self.paper,
            "published": plain(self.published),
            "corrected": plain(self.corrected),
        }


def row_of(quantity: str, unit: str, paper: str, cells: Sequence[Cell], decimals: int = 2) -> Row:
    """Row from its two cells, published and corrected."""
    published, corrected = cells
    return Row(quantity, unit, paper, published, corrected, decimals)


@dataclass(frozen=True)
class Case:
    """A figure of the paper: numbers, why they differ, and a picture of our runs."""

    name: str
    title: str
    setting: str
    rows: tuple[Row, ...]
    why: str
    figure: "Figure | None" = field(default=None, compare=False)


def sigmoid_lag(motor: Motor, g: float, rpm: float) -> float:
    """Lag [deg] of the sigmoid observer without cure, arg(g + R_s + j omega L_q), slope g [V/A]."""
    return math.degrees(math.atan2(motor.rpm_to_electrical(rpm) * motor.L_q, g + motor.R_s))

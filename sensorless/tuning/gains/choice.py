"""Which gains of a drive are tuned, and between which bounds."""

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.settings import settings_of

CONTROL = ("speed_hz", "i_q_slew", "current_hz", "dead_time_share", "smo_floor_rpm")
"""Gains that every estimator needs: of the speed and the current loop, of the inverter's
compensation, and the speed below which the EMF is not used."""
_SMO = ("smo_cross_hz", "smo_gain", "L_q_bias", "L_q_motoring")
_TWO_LOOPS = ("hfi_pll_hz", "smo_pll_hz", *_SMO)
OBSERVER = {
    "smo": _TWO_LOOPS,
    "unwrapped": _TWO_LOOPS,
    "errors": ("error_pll_hz", *_SMO),
    "flux": ("hfi_pll_hz", "flux_pll_hz", "flux_gain", "flux_L_q_bias"),
    "coupled": ("coupled_flux_hz", "coupled_injection_hz", "coupled_L_q_bias"),
}
"""Gains of each estimator, by ``DriveDesign.estimator``."""
FACTOR = 3.0
"""Largest factor between a gain and its start, either way."""
DIGITS = 4
"""Of a tuned gain: what ``--set`` is given is what was tried."""

Gains = dict[str, float]


@dataclass(frozen=True)
class Gain:
    """One gain to tune."""

    name: str
    start: float
    low: float
    """natural logarithm of the smallest factor on the start"""
    high: float
    """and of the largest"""
    allowed: tuple[float, float]
    """range of the setting"""

    def at(self, x: float) -> float:
        """Value at a factor of exp(x) within its bounds."""
        value = self.start * math.exp(min(max(x, self.low), self.high))
        return min(max(float(f"{value:.{DIGITS}g}"), self.allowed[0]), self.allowed[1])


def gains_of(motor: Motor, design: DriveDesign, fixed: Collection[str] = ()) -> list[Gain]:
    """Gains of a drive that are not ``fixed``, from where its design and its machine put them.

    Raises
    ------
    UserError
        Fewer than two are left.
    """
    values = {**dataclasses.asdict(design), **dataclasses.asdict(derive(motor, design))}
    found = []
    for name in (*OBSERVER[design.estimator], *CONTROL):
        setting, start = settings_of(DriveDesign)[name], float(values[name])
        if name in fixed or not 0.0 < start < math.inf:
            continue
        low, high = max(setting.low, start / FACTOR), min(setting.high, start * FACTOR)
        if low < high:
            x = math.log(low / start), math.log(high / start)
            found.append(Gain(name, start, *x, (setting.low, setting.high)))
    if len(found) < 2:
        raise UserError(f"set: leaves {len(found)} gains to tune; leave two or more out")
    return found


def with_gains(design: DriveDesign, gains: Mapping[str, float]) -> DriveDesign:
    """The design with these gains."""
    return dataclasses.replace(design, **gains)  # type: ignore[arg-type]


def decode(gains: Sequence[Gain], x: Sequence[float]) -> Gains:
    """Values at a point of the search, logarithms of factors."""
    return {gain.name: gain.at(float(u)) for gain, u in zip(gains, x, strict=True)}

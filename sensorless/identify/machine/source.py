"""Test commands, and where their measurements come from: a drive, or the log of one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.log import Part

VOLTAGE, CURRENT = 0, 1
ALONE = 5.0
"""Distance of an outlier from the mean of its neighbours over the next largest of its part; that of
a right reading is at most 1.5."""


@dataclass(frozen=True)
class Command:
    """One test command; see ``command_t`` in ``core/sim/commission.h``."""

    kind: int
    time: float
    """[s]; ``Source`` turns it into whole periods, at least one"""
    start: float
    """magnitude at the start, of either sign [V] or [A]"""
    end: float | None = None
    """at the end; None: as at the start"""
    theta: float | None = None
    """direction at the start [rad]; None: where the last command ended"""
    omega: tuple[float, float] = (0.0, 0.0)
    """speed of the direction at start and end [rad/s]"""
    until: float = 0.0
    """above 0: ends when the current along the command reaches it [A]"""
    damp: float = 0.0
    """how strongly the speed yields to the torque [rad/(s V)]"""
    follow: float = 0.0
    """share of a change of the torque, each period, that the speed does not yield to any more"""


def volts(time: float, start: float, theta: float | None = 0.0, **more: Any) -> Command:
    """Return a voltage [V] along ``theta``."""
    return Command(VOLTAGE, time, start, theta=theta, **more)


def amps(time: float, start: float, theta: float | None = None, **more: Any) -> Command:
    """Return a current [A] along ``theta``."""
    return Command(CURRENT, time, start, theta=theta, **more)


@dataclass(frozen=True)
class Gains:
    """Numbers of the current control."""

    R: float
    L: float
    """[H], for both axes"""
    bandwidth: float
    """[rad/s]"""


class Source(Protocol):
    """Runs commands and returns what the drive measured."""

    parts: list[Part]
    """all that was measured so far"""

    def run(self, stage: str, commands: Sequence[Command], gains: Gains | None = None) -> Part:
        """Run commands one after the other from where the last run ended."""
        ...


class Recorded:
    """Measurements from a log; commands are those that were run when it was recorded."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self.parts: list[Part] = []
        self._left = list(parts)

    def run(self, stage: str, commands: Sequence[Command], gains: Gains | None = None) -> Part:
        """Return the next part of the log.

        Raises
        ------
        UserError
            The log has no part left, or the next one is of another stage.
        """
        del commands, gains
        if not self._left or self._left[0].stage != stage:
            found = f"stage {self._left[0].stage}" if self._left else "its end"
            raise UserError(
                f"log: stage {stage} expected, {found} found: the readings lead to another step "
                "than the drive took; check the scale of currents and voltages, and that no rows "
                "are missing, or record it once more" + outlier(self.parts)
            )
        self.parts.append(self._left.pop(0))
        return self.parts[-1]


def outlier(parts: Sequence[Part]) -> str:
    """Name the reading that stands out most from its neighbours, ``ALONE``; empty for none."""
    worst, said = ALONE, ""
    for number, part in enumerate(parts):
        for name in ("i_a", "i_b"):
            i = part[name]
            bend = np.abs(i[1:-1] - 0.5 * (i[2:] + i[:-2]))
            if len(bend) < 8:
                continue
            k = int(bend.argmax())
            rest = float(np.delete(bend, range(max(k - 1, 0), min(k + 2, len(bend)))).max())
            if bend[k] > worst * rest:
                worst = float(bend[k]) / max(rest, 1e-12)
                said = (
                    f", or mend an outlier: {name} = {i[k + 1]:g} in row {k + 1} of part {number}, "
                    f"stage {part.stage}"
                )
    return said

"""Where measurements come from: the simulated drive, or a recorded log."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from sensorless.core.api import Array
from sensorless.core.machine import COMMAND, commission_run
from sensorless.errors import UserError
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate

VOLTAGE, CURRENT = 0, 1


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
            raise UserError(f"log: stage {stage} expected, {found} found; record it once more")
        self.parts.append(self._left.pop(0))
        return self.parts[-1]


class Simulated:
    """The simulated drive; ``sims`` is one started ``SIM``, shape (1,), of the true machine."""

    def __init__(self, sims: Array, plate: Nameplate) -> None:
        self.parts: list[Part] = []
        self._sim = sims
        self._plate = plate

    def run(self, stage: str, commands: Sequence[Command], gains: Gains | None = None) -> Part:
        """Run commands through inverter, machine and sensors, in one call of the core.

        Raises
        ------
        UserError
            The current exceeds the name plate's limit.
        """
        if gains is not None:
            _set_gains(self._sim, gains, self._plate)
        limit = self._plate.i_limit
        rows = commission_run(self._sim, _records(commands, self._plate.T_s), limit)
        part = Part(stage, rows)
        self.parts.append(part)
        i = part["i_a"][-1] + 1j * (part["i_a"][-1] + 2.0 * part["i_b"][-1]) / np.sqrt(3.0)
        if abs(i) > limit:
            raise UserError(
                f"stage {stage}: current above {limit:.3g} A; check the name plate's rated current "
                "and voltage"
            )
        return part


def _records(commands: Sequence[Command], T_s: float) -> Array:
    out = np.zeros(len(commands), dtype=COMMAND)
    for row, c in zip(out, commands, strict=True):
        row["kind"], row["n"] = c.kind, max(1, round(c.time / T_s))
        row["from"], row["to"] = c.start, c.start if c.end is None else c.end
        row["go_on"], row["theta"] = int(c.theta is None), c.theta or 0.0
        row["omega_0"], row["omega_1"] = c.omega
        row["i_end"] = c.until
        row["damp"], row["follow"] = c.damp, c.follow
    return out


def _set_gains(sims: Array, g: Gains, plate: Nameplate) -> None:
    """Fill the current control with the same numbers for both axes; nothing else of it is used."""
    control = sims["control"]["control"]
    control[...] = 0
    for axis in "dq":
        control[f"k_t_{axis}"] = g.bandwidth * g.L
        control[f"k_p_{axis}"] = 2.0 * g.bandwidth * g.L - g.R
        control[f"k_i_{axis}"] = g.bandwidth**2 * g.L * plate.T_s
        control[f"L_{axis}"] = g.L
    control["i_d_min"] = -plate.i_rated

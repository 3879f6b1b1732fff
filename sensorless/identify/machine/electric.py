"""What lies between the commanded voltage and the winding: sensors, inverter, resistance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.identify.machine.log import Part
from sensorless.machine.magnetics import Floats
from sensorless.machine.phases import clarke, leg_losses, phases_of, with_third

Complex = NDArray[np.complex128]


def plane(vector: Floats) -> Complex:
    """Return a vector (n, 2) as (n,) alpha + j beta, or d + j q."""
    return np.asarray(vector[:, 0] + 1j * vector[:, 1])


def parts(x: Complex) -> Floats:
    """Return (n,) complex numbers as a vector (n, 2): the inverse of ``plane``."""
    return np.stack([x.real, x.imag], axis=-1)


@dataclass(frozen=True)
class Sensors:
    """Offsets and gains of the two current channels."""

    offset: tuple[float, float] = (0.0, 0.0)
    """[A]"""
    ratio: float = 1.0
    """gain of channel b over that of channel a"""

    def current(self, part: Part) -> Complex:
        """(n,) current alpha + j beta [A], as if both gains were their geometric mean."""
        half = np.sqrt(self.ratio)
        a = (part["i_a"] - self.offset[0]) * half
        b = (part["i_b"] - self.offset[1]) / half
        return plane(clarke(with_third(a, b)))


@dataclass(frozen=True)
class Inverter:
    """Voltage that a leg loses to dead time and thresholds: odd, linear up to ``i_zero``."""

    u_lost: float = 0.0
    """above ``i_zero`` [V]"""
    i_zero: float = 1.0
    """[A]"""

    def lost(self, i: Complex) -> Complex:
        """(n,) voltage lost at the currents i [A], alpha + j beta [V]."""
        legs = phases_of(parts(i))
        return plane(clarke(leg_losses(legs, self.u_lost, 1.0 / self.i_zero)))


@dataclass(frozen=True)
class Stator:
    """All that is needed to find the EMF from commands and measured currents."""

    sensors: Sensors
    inverter: Inverter
    R_s: float
    """[ohm]"""
    T_s: float
    """[s]"""

    def emf(self, part: Part) -> tuple[Complex, Complex]:
        """Currents (n,) [A] and the mean voltages (n - 1,) [V] behind the resistance between them.

        The current between two samples is their mean.
        """
        i = self.sensors.current(part)
        return i, np.asarray(part.u[:-1] - self.lost(i) - 0.5 * self.R_s * (i[1:] + i[:-1]))

    def lost(self, i: Complex) -> Complex:
        """(n - 1,) voltage lost between samples of the current i (n,) [V].

        A leg switches once before and once after the middle of the period, so it is the mean of
        those at the two samples.
        """
        lost = self.inverter.lost(i)
        return np.asarray(0.5 * (lost[1:] + lost[:-1]))


def windows(part: Part, tail: float, T_s: float) -> list[slice]:
    """Last ``tail`` seconds of every command of a part."""
    segment = part["segment"]
    ends = np.flatnonzero(np.r_[np.diff(segment) != 0, True]) + 1
    starts = np.r_[0, ends[:-1]]
    n = max(1, round(tail / T_s))
    return [slice(max(int(a), int(b) - n), int(b)) for a, b in zip(starts, ends, strict=True)]


def rms(x: Floats) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.abs(x) ** 2)))

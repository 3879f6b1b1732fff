"""Random numbers as a pure function of (seed, column), whatever batch they are drawn in."""

from dataclasses import dataclass, field
from functools import lru_cache
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.errors import UserError, shown

Seeds = NDArray[np.uint64]
Floats = NDArray[np.float64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FACTORS = np.array([0xBF58476D1CE4E5B9, 0x94D049BB133111EB], dtype=np.uint64)
_SHIFTS = np.array([30, 27, 31], dtype=np.uint64)


LARGEST = 2**63 - 1
"""Seed that a command takes."""


def check_seed(seed: int, largest: int = LARGEST) -> None:
    """Check the seed of a command.

    Raises
    ------
    UserError
        It is no whole number, or out of range.
    """
    if not isinstance(seed, Integral) or not 0 <= seed <= largest:
        known = "2^63 - 1" if largest == LARGEST else largest
        raise UserError(f"seed: {shown(seed)}; give 0 to {known}")


def mix(x: Seeds) -> Seeds:
    """SplitMix64 finaliser (doi 10.1145/2714064.2660195) of each element of (n,) numbers."""
    z = x + _GOLDEN
    z = (z ^ (z >> _SHIFTS[0])) * _FACTORS[0]
    z = (z ^ (z >> _SHIFTS[1])) * _FACTORS[1]
    return np.asarray(z ^ (z >> _SHIFTS[2]))


@lru_cache(maxsize=4096)
def _mixed(number: int) -> Seeds:
    return mix(np.array([number]).astype(np.uint64))


def combine(*parts: NDArray[Any] | int) -> Seeds:
    """One seed from several integers or arrays of them; order matters."""
    out = np.zeros(1, dtype=np.uint64)
    for part in parts:
        if isinstance(part, int):
            word = _mixed(part)
        else:
            word = mix(np.atleast_1d(np.asarray(part).astype(np.uint64)))
        out = mix(out ^ word)
    return out


@dataclass(frozen=True)
class Chosen:
    """Seeds whose numbers in [0, 1) are chosen: those not in ``units`` are drawn and kept there."""

    seeds: Seeds
    units: dict[tuple[int, int], Floats] = field(default_factory=dict)
    """(n,) by part and column of ``Draws``"""


class Draws:
    """Independent uniform numbers for every seed; each call uses a new column.

    Parameters
    ----------
    source : Seeds or Chosen
    part : int
        Numbers of another part have nothing to do with those of the first, 0.
    """

    def __init__(self, source: "Seeds | Chosen", part: int = 0) -> None:
        self._units = source.units if isinstance(source, Chosen) else {}
        seeds = source.seeds if isinstance(source, Chosen) else source
        self.seeds = np.asarray(seeds, dtype=np.uint64)
        """of the first part"""
        self._of_part = combine(self.seeds, part) if part else self.seeds
        self._part, self._column = part, 0

    def uniform(self, low: float | Floats = 0.0, high: float | Floats = 1.0) -> Floats:
        """Uniform in [low, high), shape of the seeds."""
        self._column += 1
        key = self._part, self._column
        if key not in self._units:
            bits = combine(self._of_part, self._column) >> np.uint64(11)
            self._units[key] = bits.astype(np.float64) * 2.0**-53
        return np.asarray(low + (np.asarray(high) - low) * self._units[key])

    def chance(self, probability: float) -> NDArray[np.bool_]:
        """True with the given probability."""
        return np.asarray(self.uniform() < probability)

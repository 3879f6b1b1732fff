"""Random numbers as a pure function of (seed, column), whatever batch they are drawn in."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Seeds = NDArray[np.uint64]
Floats = NDArray[np.float64]

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def mix(x: Seeds) -> Seeds:
    """SplitMix64 finaliser (doi 10.1145/2714064.2660195) of each element."""
    with np.errstate(over="ignore"):
        z = np.asarray(x, dtype=np.uint64) + _GOLDEN
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(z ^ (z >> np.uint64(31)))


def combine(*parts: NDArray[Any] | int) -> Seeds:
    """One seed from several integers or arrays of them; order matters."""
    out = np.zeros(1, dtype=np.uint64)
    for part in parts:
        word = np.asarray(part).astype(np.uint64)
        out = mix(out ^ mix(np.atleast_1d(word)))
    return out


class Draws:
    """Independent uniform numbers for every seed; each call uses a new column."""

    def __init__(self, seeds: Seeds) -> None:
        self.seeds = np.asarray(seeds, dtype=np.uint64)
        self._column = 0

    def uniform(self, low: float | Floats = 0.0, high: float | Floats = 1.0) -> Floats:
        """Uniform in [low, high), shape of the seeds."""
        self._column += 1
        bits = combine(self.seeds, self._column) >> np.uint64(11)
        return np.asarray(low + (np.asarray(high) - low) * (bits.astype(np.float64) * 2.0**-53))

    def chance(self, probability: float) -> NDArray[np.bool_]:
        """True with the given probability."""
        return np.asarray(self.uniform() < probability)

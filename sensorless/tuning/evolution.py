"""CMA-ES, an evolutionary search, repeatable from a seed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sensorless.errors import UserError

if TYPE_CHECKING:
    from cma import CMAEvolutionStrategy

Bound = float | Sequence[float]


def evolution(
    start: Sequence[float], sigma: float, seed: int, low: Bound = 0.0, high: Bound = 1.0
) -> "CMAEvolutionStrategy":
    """Search between bounds, of all coordinates or of each, from a point of two or more.

    Raises
    ------
    UserError
        The library cma is missing.
    """
    try:
        import cma
    except ImportError:
        raise UserError("tune needs the library cma; run: pip install 'sensorless[tune]'") from None
    rng = np.random.default_rng(seed)
    options = {
        "bounds": [low, high],
        "randn": lambda rows, columns: rng.standard_normal((rows, columns)),
        "seed": np.nan,
        "verbose": -9,
        "verb_log": 0,
        "tolflatfitness": 20,
    }
    return cma.CMAEvolutionStrategy(start, sigma, options)

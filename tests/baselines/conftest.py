"""Signals of a few drives by name."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.policy import Signals

Make = Callable[..., Signals]


@pytest.fixture
def signals() -> Make:
    """Function from columns by name to signals (n, SIGNAL_N), zero elsewhere."""

    def make(**columns: Sequence[float] | float) -> Signals:
        rows = np.broadcast_arrays(*map(np.atleast_1d, columns.values()))
        obs = np.zeros((len(rows[0]), SIGNAL_N), dtype=np.float32)
        for name, x in zip(columns, rows, strict=True):
            obs[:, SIGNAL_NAMES.index(name)] = x
        return obs

    return make

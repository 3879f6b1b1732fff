"""One weight at all times: 1 is injection alone, 0 the sliding-mode observer alone."""

import numpy as np

from sensorless.ks_table import Axis, KsTable


def constant_table(k_s: float) -> KsTable:
    """Table with the same weight ``k_s``, 0 to 1, at each of its nodes."""
    return KsTable((Axis("speed", 0.0, 1.0, 2),), np.full(2, k_s, dtype=np.float32))

"""The same weight everywhere."""

import numpy as np
import pytest

from sensorless.baselines.constant import constant_table
from sensorless.core.api import SIGNAL_N


@pytest.mark.parametrize("k_s", [0.0, 0.1, 0.37, 0.5, 1.0])
def test_the_weight_is_exact_at_any_signals(k_s: float) -> None:
    rng = np.random.default_rng(1)
    obs = rng.uniform(-2.0, 2.0, (50, SIGNAL_N)).astype(np.float32)
    assert set(constant_table(k_s).evaluate(obs)) == {np.float32(k_s)}

"""The ramp of Eq. 25 as a table."""

import numpy as np
import pytest

from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.policy import TablePolicy


def at_speed(*speeds: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    """Signals that are zero but for the speed over rated speed."""
    obs = np.zeros((len(speeds), SIGNAL_N), dtype=np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = speeds
    return obs


def test_eq25_in_r_min_of_the_paper() -> None:
    speeds = np.array([0.0, 200.0, 300.0, 325.0, 350.0, 375.0, 400.0, 600.0, 1500.0])
    k_s = TablePolicy("eq25", linear_table(*EQ25_BAND)).act(at_speed(*speeds / 1500.0))
    expected = np.clip((400.0 - speeds) / 100.0, 0.0, 1.0)
    np.testing.assert_allclose(k_s, expected, atol=2e-6)
    assert k_s.dtype == np.float32


@pytest.mark.parametrize(("low", "high"), [(0.0, 0.1), (0.05, 0.15), (0.2, 0.21), (0.3, 1.2)])
def test_one_up_to_and_at_the_lower_end_zero_from_the_upper_end(low: float, high: float) -> None:
    table = linear_table(low, high)
    inside = np.linspace(low, high, 101, dtype=np.float32)
    k_s = table.evaluate(at_speed(*inside))
    assert k_s[0] == 1.0
    assert k_s[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.all(np.diff(k_s) < 0.0)
    np.testing.assert_allclose(k_s, (high - inside) / (high - low), atol=2e-5)
    assert table.evaluate(at_speed(high * 1.001, 9.0)).tolist() == [0.0, 0.0]


def test_other_signals_are_without_effect() -> None:
    obs = at_speed(0.23, 0.23)
    obs[1, np.arange(SIGNAL_N) != SIGNAL_NAMES.index("speed")] = 0.7
    k_s = linear_table(*EQ25_BAND).evaluate(obs)
    assert k_s[0] == k_s[1]

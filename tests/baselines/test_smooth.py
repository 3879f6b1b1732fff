"""Curves of the speed: at the formula's values, and nowhere further off than they say."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.smooth import quadratic_table, sine_table, smoothstep_table
from sensorless.policy import Signals
from sensorless.table.ks_table import KsTable

LOW, HIGH = 0.1, 0.4


def smoothstep(v: np.ndarray) -> np.ndarray:
    u = np.clip((HIGH - v) / (HIGH - LOW), 0.0, 1.0)
    return np.asarray(u**2 * (3.0 - 2.0 * u))


def sine(v: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(0.5 * np.pi * np.clip((HIGH - v) / (HIGH - LOW), 0.0, 1.0)))


def quadratic(v: np.ndarray) -> np.ndarray:
    return np.asarray(np.maximum(0.0, 1.0 - (v / HIGH) ** 2))


@pytest.mark.parametrize(
    ("table", "formula", "off"),
    [
        (smoothstep_table(LOW, HIGH), smoothstep, 1.9e-4),
        (sine_table(LOW, HIGH), sine, 7.6e-5),
        (quadratic_table(HIGH), quadratic, 6.2e-5),
    ],
    ids=["smoothstep", "sine", "quadratic"],
)
def test_deviation_from_the_formula_is_as_stated(
    table: KsTable,
    formula: Callable[[np.ndarray], np.ndarray],
    off: float,
    signals: Callable[..., Signals],
) -> None:
    v = np.linspace(0.0, 0.6, 20001)
    worst = np.abs(table.evaluate(signals(speed=v)) - formula(v)).max()
    assert 0.5 * off < worst <= off + 1e-6


def test_smoothstep_passes_the_middle(signals: Callable[..., Signals]) -> None:
    k_s = smoothstep_table(LOW, HIGH).evaluate(signals(speed=[0.05, 0.1, 0.175, 0.25, 0.4, 2.0]))
    assert k_s == pytest.approx([1.0, 1.0, 0.84375, 0.5, 0.0, 0.0], abs=2e-4)

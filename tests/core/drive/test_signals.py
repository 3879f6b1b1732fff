"""The disagreement of the estimators as a schedule sees it."""

import math
from collections.abc import Callable

import numpy as np
import pytest

Call = Callable[..., None]


def disagreement(c: Call, d: np.ndarray) -> np.ndarray:
    """Signal [rad] of differences of angles d [rad]."""
    y = np.zeros(len(d), np.float32)
    c("disagreement", d.astype(np.float32), y, len(d))
    return y


def test_disagreement_is_the_difference_within_a_quarter_turn(c: Call) -> None:
    """To the bit, so that schedules made on the difference see what they saw."""
    d = np.random.default_rng(5).uniform(-0.5 * math.pi, 0.5 * math.pi, 2000).astype(np.float32)
    assert np.array_equal(disagreement(c, d), d)


def test_disagreement_does_not_jump_while_an_estimate_slips(c: Call) -> None:
    """Two whole turns: no step is larger than that of the angle, and half a turn gives 0."""
    slip = np.linspace(-2.0 * math.pi, 2.0 * math.pi, 2001)
    y = disagreement(c, np.angle(np.exp(1j * slip)))
    assert np.max(np.abs(np.diff(y))) < 1.001 * (slip[1] - slip[0])
    assert np.max(np.abs(y)) == pytest.approx(0.5 * math.pi, rel=1e-6)
    assert np.all(np.abs(y[np.isclose(np.abs(slip), math.pi)]) < 1e-6)

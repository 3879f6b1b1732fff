"""Frames and the core's own trigonometry against NumPy in double precision."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import Array

Call = Callable[..., None]


def f32(x: object) -> Array:
    return np.ascontiguousarray(x, dtype=np.float32)


def rot_of(c: Call, x: Array) -> Array:
    y = np.empty((len(x), 2), dtype=np.float32)
    c("rot_of", x, y, len(x))
    return y


def test_sine_and_cosine(c: Call) -> None:
    """Error below 2e-7 on [-8, 8], length 1 within 3e-7."""
    x = f32(np.linspace(-8.0, 8.0, 400_001))
    y = rot_of(c, x).astype(float)
    want = np.stack([np.cos(x.astype(float)), np.sin(x.astype(float))], axis=-1)
    assert np.max(np.abs(y - want)) < 2e-7
    assert np.max(np.abs(np.hypot(y[:, 0], y[:, 1]) - 1.0)) < 3e-7


def test_symmetry_and_quarter_turns(c: Call) -> None:
    """Cosine is even and sine odd to the bit; 0 gives exactly (1, 0)."""
    x = f32(np.random.default_rng(1).uniform(0.0, 8.0, 5000))
    plus, minus = rot_of(c, x), rot_of(c, -x)
    assert np.array_equal(plus[:, 0], minus[:, 0])
    assert np.array_equal(plus[:, 1], -minus[:, 1])
    assert rot_of(c, f32([0.0])).tolist() == [[1.0, 0.0]]


def test_sine_is_finite_far_outside(c: Call) -> None:
    """A wild but finite angle up to 1e9 gives finite numbers."""
    x = f32([1e3, -1e5, 3e7, -1e9, 1e9, 1e-40])
    assert np.all(np.isfinite(rot_of(c, x)))


def test_turn(c: Call) -> None:
    """Turning by x < 0.25 errs by less than x^4 / 24 and float round-off."""
    rng = np.random.default_rng(2)
    at, x = rng.uniform(-np.pi, np.pi, 5000), f32(rng.uniform(-0.25, 0.25, 5000))
    r = rot_of(c, f32(at))
    y = np.empty_like(r)
    c("rot_turn", r, x, y, len(x))
    got = y[:, 0] + 1j * y[:, 1].astype(float)
    want = (r[:, 0] + 1j * r[:, 1].astype(float)) * np.exp(1j * x.astype(float))
    assert np.all(np.abs(got - want) < np.abs(x.astype(float)) ** 4 / 24.0 + 2e-7)


def test_tanh(c: Call) -> None:
    """Error below 1.1e-6 for |x| < 3 and below 1e-4 beyond; odd, monotone, ends at exactly +-1."""
    x = f32(np.linspace(-20.0, 20.0, 400_001))
    y = np.empty_like(x)
    c("tanh", x, y, len(x))
    gap = np.abs(y - np.tanh(x.astype(float)))
    assert np.max(gap) < 1e-4
    assert np.max(gap[np.abs(x) < 3.0]) < 1.1e-6
    assert np.all(np.diff(y) >= -3e-7)  # monotone but for round-off
    assert np.max(np.abs(y)) <= 1.0
    mirrored = np.empty_like(x)
    c("tanh", -x, mirrored, len(x))
    assert np.array_equal(mirrored, -y)
    ends = f32([5.5, -6.0, 1e30, -1e38, math.inf, -math.inf])
    out = np.empty_like(ends)
    c("tanh", ends, out, len(ends))
    assert np.array_equal(out, np.sign(ends))


def test_wrap(c: Call) -> None:
    """Angles within +-3 pi come into [-pi, pi] and stay the same direction."""
    x = f32(np.linspace(-9.42, 9.42, 100_001))
    y = np.empty_like(x)
    c("wrap", x, y, len(x))
    assert np.max(np.abs(y)) <= np.float32(np.pi) * (1.0 + 1e-6)
    assert np.max(np.abs(np.exp(1j * y.astype(float)) - np.exp(1j * x.astype(float)))) < 2e-6


@pytest.mark.parametrize(
    ("x", "want"), [(0.5, 0.5), (-3.0, -1.0), (9.0, 2.0), (math.nan, -1.0), (math.inf, 2.0)]
)
def test_clamp(c: Call, x: float, want: float) -> None:
    """Limits hold for every input; NaN comes out as the lower one."""
    y = np.empty(1, dtype=np.float32)
    c("clamp", f32([x]), -1.0, 2.0, y, 1)
    assert y[0] == want


def test_park_and_back(c: Call) -> None:
    """d lies along the angle, q a quarter turn ahead, and the inverse undoes it."""
    rng = np.random.default_rng(3)
    ab, theta = f32(rng.normal(size=(2000, 2))), f32(rng.uniform(-np.pi, np.pi, 2000))
    dq, back = np.empty_like(ab), np.empty_like(ab)
    c("park", ab, theta, dq, back, len(theta))
    want = (ab[:, 0] + 1j * ab[:, 1].astype(float)) * np.exp(-1j * theta.astype(float))
    assert np.max(np.abs(dq[:, 0] + 1j * dq[:, 1].astype(float) - want)) < 2e-6
    assert np.max(np.abs(back - ab)) < 3e-6


def angle_of(c: Call, x: Array) -> Array:
    y = np.empty(len(x), dtype=np.float32)
    c("angle_of", x, y, len(x))
    return y


def test_angle_of_a_vector(c: Call) -> None:
    """Error below 1e-6 all around, for any length."""
    theta = np.linspace(-np.pi, np.pi, 200_001)
    for length in (1e-12, 1.0, 1e9):
        x = f32(length * np.stack([np.cos(theta), np.sin(theta)], axis=-1))
        want = np.arctan2(x[:, 1].astype(float), x[:, 0].astype(float))
        gap = angle_of(c, x).astype(float) - want
        assert np.max(np.abs(np.angle(np.exp(1j * gap)))) < 1e-6


def test_angle_on_the_axes(c: Call) -> None:
    """The four axes and the zero vector; a negative zero does not turn the angle of +alpha."""
    x = f32([[1, 0], [0, 1], [-1, 0], [0, -1], [0, 0], [1, -0.0]])
    want = f32([0.0, np.pi / 2, np.pi, -np.pi / 2, 0.0, 0.0])
    assert np.max(np.abs(angle_of(c, x) - want)) < 1e-6


def test_small_angle_of_the_plant(c: Call) -> None:
    """Double-precision series: within 2e-14 below half a radian, 1e-15 below 0.35."""
    x = np.linspace(-0.5, 0.5, 20_001)
    y = np.empty((len(x), 2))
    c("small_angle", x, y, len(x))
    gap = np.max(np.abs(y - np.stack([np.cos(x), np.sin(x)], axis=-1)), axis=1)
    assert np.max(gap) < 2e-14
    assert np.max(gap[np.abs(x) < 0.35]) < 1e-15

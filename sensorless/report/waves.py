"""Waveforms for a page: few points that keep every peak, as bytes that a browser inflates."""

import base64
import zlib
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.plots.wave import Wave

POINTS = 1800
"""Most points of a curve: the least and the largest value of each of half as many bins."""
ALL = 36_000
"""Most points of a curve in all cases of a page, which bounds its size."""
LEVELS = 4000
"""Steps from the least to the largest value of a curve; few, so that they pack well."""
NONE = -32768


def packed(wave: Wave, cases: int = 1) -> dict[str, Any]:
    """All of it in JSON types, for a page that has so many cases."""
    t, order = thinned(wave.t, min(POINTS, ALL // cases))
    raw, panes = [t.astype("<f4").tobytes()], []
    for pane in wave.panes:
        curves = []
        for curve in pane.curves:
            whole, low, step = _levels(order(curve.values))
            raw.append(whole.tobytes())
            curves.append(
                {"name": curve.name, "colour": curve.colour, "width": curve.width,
                 "dash": curve.dash, "low": low, "step": step}
            )  # fmt: skip
        panes.append({"key": pane.key, "label": pane.label, "span": pane.span, "curves": curves})
    return {
        "title": wave.title, "n": len(t), "panes": panes, "bands": wave.bands,
        "marks": wave.marks, "data": base64.b64encode(zlib.compress(b"".join(raw), 9)).decode(),
    }  # fmt: skip


def thinned(t: Array, points: int) -> tuple[Array, Any]:
    """Times of at most about ``points`` points, and what thins a curve (n,) to them."""
    n = len(t)
    if n <= points:
        return np.asarray(t, dtype=np.float64), lambda x: np.asarray(x, dtype=np.float64)
    width = -(-2 * n // points)
    first = np.arange(0, n - 1, width)  # the last bin has two rows at least
    times = np.stack([t[first], t[np.minimum(first + width // 2, n - 1)]], axis=1)

    def extremes(x: Array) -> Array:
        values = np.asarray(x, dtype=np.float64)
        return np.stack(
            [np.fmin.reduceat(values, first), np.fmax.reduceat(values, first)], axis=1
        ).ravel()

    return times.ravel(), extremes


def _levels(x: Array) -> tuple[Array, float, float]:
    known = x[np.isfinite(x)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
    step = (high - low) / LEVELS or 1.0
    whole = np.where(np.isfinite(x), np.rint((x - low) / step) - LEVELS // 2, NONE)
    return whole.astype("<i2"), low, step

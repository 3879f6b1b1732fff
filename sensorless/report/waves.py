"""Waveforms for a page: few points that keep every peak, as bytes that a browser inflates."""

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.evaluation.trace import Trace, outcome
from sensorless.units import RAD_S_TO_RPM

POINTS = 2400
"""Most points of a curve: the least and the largest value of each of half as many bins."""
LEVELS = 4000
"""Steps from the least to the largest value of a curve; few, so that they pack well."""
NONE = -32768
DASH = (7, 7)


@dataclass(frozen=True)
class Curve:
    """One curve over time."""

    name: str
    colour: str
    """variable of ``style.css`` without its dashes"""
    values: Array
    """(n,), NaN where there is none"""
    width: float = 1.2
    dash: Sequence[int] = ()
    """lengths of strokes and gaps, of a curve that may lie on another one"""


@dataclass(frozen=True)
class Pane:
    """Curves with one axis."""

    label: str
    curves: Sequence[Curve]
    span: tuple[float, float] | None = None
    """of the axis; by default that of the curves"""
    folded: bool = False
    """shown only when asked for"""


@dataclass(frozen=True)
class Wave:
    """One run."""

    title: str
    t: Array
    """(n,) [s]"""
    panes: Sequence[Pane]
    bands: Sequence[tuple[float, float, str, str]] = ()
    """from, to [s], what it is, colour"""
    marks: Sequence[tuple[float, str, str]] = ()
    """time [s], what happens, colour"""

    def packed(self) -> dict[str, Any]:
        """All of it in JSON types."""
        t, order = thinned(self.t)
        raw, panes = [t.astype("<f4").tobytes()], []
        for pane in self.panes:
            curves = []
            for curve in pane.curves:
                whole, low, step = _levels(order(curve.values))
                raw.append(whole.tobytes())
                curves.append(
                    {"name": curve.name, "colour": curve.colour, "width": curve.width,
                     "dash": curve.dash, "low": low, "step": step}
                )  # fmt: skip
            panes.append(
                {"label": pane.label, "span": pane.span, "folded": pane.folded, "curves": curves}
            )
        return {
            "title": self.title, "n": len(t), "panes": panes, "bands": self.bands,
            "marks": self.marks, "data": base64.b64encode(zlib.compress(b"".join(raw), 9)).decode(),
        }  # fmt: skip


def thinned(t: Array) -> tuple[Array, Any]:
    """Times of at most about ``POINTS`` points, and what thins a curve (n,) to them."""
    n = len(t)
    if n <= POINTS:
        return np.asarray(t, dtype=np.float64), lambda x: np.asarray(x, dtype=np.float64)
    width = -(-2 * n // POINTS)
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


def wave(title: str, t: Trace) -> Wave:
    """Waveforms of a simulated run."""
    worst = np.abs(np.rad2deg(t["theta_e_err"][t["starting"] == 0.0]))
    error = min(float(np.quantile(worst, 0.999)), 90.0) if len(worst) else 90.0
    edge = max(6.0, 1.6 * error)
    c, s = np.cos(t["theta_e"]), np.sin(t["theta_e"])
    u_d, u_q = c * t["u_a"] + s * t["u_b"], c * t["u_b"] - s * t["u_a"]
    rpm = {key: RAD_S_TO_RPM * t[f"omega_m{key}"] for key in ("_ref", "", "_hat", "_twin")}
    panes = (
        Pane("speed [r/min]", (
            Curve("sensored twin", "twin", rpm["_twin"], 5.0),
            Curve("sensorless", "own", rpm[""], 2.2),
            Curve("estimate", "observer", rpm["_hat"], 1.4, DASH),
            Curve("reference", "ref", rpm["_ref"]),
        )),
        Pane("torque [N m]", (
            Curve("torque", "faint", t["tau"], 3.0),
            Curve("sensored twin", "twin", mean_of_two(t["tau_twin"]), 5.0),
            Curve("without injection", "own", mean_of_two(t["tau"])),
            Curve("load", "ref", t["tau_load"]),
        )),
        Pane("angle error [° el.], truth − estimate", (
            Curve("HFI", "hfi", np.rad2deg(t["theta_e_err_hfi"])),
            Curve("blend", "own", np.rad2deg(t["theta_e_err"]), 2.2),
            Curve("observer", "observer", np.rad2deg(t["theta_e_err_smo"]), 1.4, DASH),
        ), (-edge, edge)),
        Pane("weight k_s: 1 HFI, 0 observer", (Curve("k_s", "own", t["k_s"]),), (-0.05, 1.05)),
        Pane("current [A], rotor frame", (
            Curve("i_q", "observer", t["i_q"]), Curve("i_d", "hfi", t["i_d"]),
        ), folded=True),
        Pane("voltage [V], rotor frame", (
            Curve("u_q", "observer", u_q), Curve("u_d", "hfi", u_d),
            Curve("limit", "ref", t["u_dc"] / np.sqrt(3.0)),
        ), folded=True),
    )  # fmt: skip
    return Wave(f"{title}: {outcome(t)}", t["t"], panes, *events(t))


def events(
    t: Trace,
) -> tuple[list[tuple[float, float, str, str]], list[tuple[float, str, str]]]:
    """Bands and marks of a run: start, recovery, verdict of lost lock, alarms."""
    bands = []
    for key, text, colour in (("starting", "start", "faint"), ("recovering", "recovery", "bad")):
        edges = np.diff((t[key] > 0.0).astype(np.int8), prepend=0, append=0)
        for a, b in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
            bands.append((float(t["t"][a]), float(t["t"][b - 1]), text, colour))
    marks = [(float(t["t"][t["judged"]][0]), "lost", "text")] if t["judged"].any() else []
    alarms = np.flatnonzero(np.diff(t["alarm"].astype(np.int8), prepend=0) == 1)
    return bands, marks + [(float(t["t"][j]), "alarm", "bad") for j in alarms]


def mean_of_two(x: Array) -> Array:
    """Mean of two successive samples: without the injected part."""
    return np.asarray(0.5 * (x + np.concatenate([x[:1], x[:-1]])))

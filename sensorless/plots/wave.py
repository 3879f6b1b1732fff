"""What a run shows over time: panes of curves, bands and marks; for pictures and for pages."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sensorless.core.api import Array, enumeration
from sensorless.evaluation.trace import Trace, mean_of_two, outcome
from sensorless.units import RAD_S_TO_RPM

FOLDED = ("current", "voltage", "faults")
"""Panes that are shown only when asked for."""
FAULTS = {k.replace("_", " "): bit for k, bit in enumeration("FAULT_").items() if k != "all"}
"""Bits of the drive's fault word by name."""
BEYOND = 2.5
"""How far from the middle of what was judged curves go on after it, over its range."""
DASH = (7, 7)
COLOURS = ("hfi", "observer", "ekf", "ref", "own")
"""Of what has none of its own."""


@dataclass(frozen=True)
class Curve:
    """One curve over time."""

    name: str
    colour: str
    """name in ``figure.PALETTE``, and in the style of a page"""
    values: Array
    """(n,), NaN where there is none"""
    width: float = 1.2
    dash: Sequence[int] = ()
    """lengths of strokes and gaps, of a curve that may lie on another one"""


@dataclass(frozen=True)
class Pane:
    """Curves with one axis."""

    key: str
    label: str
    curves: Sequence[Curve]
    span: tuple[float, float] | None = None
    """of the axis; by default that of the curves"""


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


def wave(title: str, t: Trace) -> Wave:
    """Waveforms of a simulated run."""
    worst = np.abs(np.rad2deg(t["theta_e_err"][t["starting"] == 0.0]))
    error = min(float(np.quantile(worst, 0.999)), 90.0) if len(worst) else 90.0
    edge = max(6.0, 1.6 * error)
    angles = {"HFI": "_hfi", "blend": "", "observer": "_smo"}
    peaks = {n: np.nanmax(np.abs(np.rad2deg(t[f"theta_e_err{x}"]))) for n, x in angles.items()}
    beyond = ", ".join(name for name, peak in peaks.items() if peak > edge)
    label = "angle error [° el.], truth − estimate" + (f", {beyond} cut off" if beyond else "")
    c, s = np.cos(t["theta_e"]), np.sin(t["theta_e"])
    u_alpha, u_beta = t["u_alpha"], t["u_beta"]
    u_d, u_q = c * u_alpha + s * u_beta, c * u_beta - s * u_alpha
    rpm = {key: RAD_S_TO_RPM * t[f"omega_m{key}"] for key in ("_ref", "", "_hat", "_twin")}
    panes = (
        Pane("speed", "speed [r/min]", (
            Curve("sensored twin", "twin", rpm["_twin"], 5.0),
            Curve("sensorless", "own", rpm[""], 2.2),
            Curve("estimate", "observer", rpm["_hat"], 1.4, DASH),
            Curve("reference", "ref", rpm["_ref"]),
        )),
        Pane("torque", "torque [N m]", (
            Curve("torque", "faint", t["tau"], 3.0),
            Curve("sensored twin", "twin", mean_of_two(t["tau_twin"]), 5.0),
            Curve("without injection", "own", mean_of_two(t["tau"])),
            Curve("load", "ref", t["tau_load"]),
        )),
        Pane("angle", label, merged([
            Curve("HFI", "blush", np.rad2deg(t["theta_e_err_hfi"]), 2.6),
            Curve("blend", "own", np.rad2deg(t["theta_e_err"]), 1.8),
            Curve("observer", "observer", np.rad2deg(t["theta_e_err_smo"]), 1.4, DASH),
        ]), (-edge, edge)),
        Pane("weight", "weight k_s: 1 HFI, 0 observer", (
            Curve("k_s", "own", t["k_s"]),
        ), (-0.05, 1.05)),
        Pane("current", "current [A], rotor frame", (
            Curve("i_d", "hfi", t["i_d"]), Curve("i_q", "observer", t["i_q"]),
        )),
        Pane("voltage", "voltage [V], rotor frame", (
            Curve("u_d with injection", "faint", u_d, 2.0),
            Curve("u_q", "observer", mean_of_two(u_q)), Curve("u_d", "hfi", mean_of_two(u_d)),
            Curve("limit", "ref", t["u_dc"] / np.sqrt(3.0)),
        )),
        Pane("faults", "faults: up while they are set", faults(t["fault"])),
    )  # fmt: skip
    shown = [within(pane, t["judged"]) for pane in panes]
    return Wave(f"{title}: {outcome(t)}", t["t"], shown, *events(t))


def within(pane: Pane, judged: Array) -> Pane:
    """Without what lies far beyond all that was judged and asked for.

    A lost drive may turn so fast that nothing else would show.

    Parameters
    ----------
    judged : (n,) bool: after the verdict
    """
    if not judged.any() or pane.span is not None or pane.key == "faults":
        return pane
    seen = [c.values if c.colour == "ref" else c.values[~judged] for c in pane.curves]
    low = min(float(np.nanmin(x)) for x in seen)
    high = max(float(np.nanmax(x)) for x in seen)
    room = BEYOND * (high - low)
    curves = [
        replace(c, values=np.where(np.abs(c.values - 0.5 * (low + high)) <= room, c.values, np.nan))
        for c in pane.curves
    ]
    return replace(pane, curves=curves)


def merged(curves: Sequence[Curve]) -> list[Curve]:
    """One curve for those that are the same, under all their names: none hides another."""
    out: list[Curve] = []
    for curve in curves:
        for j, other in enumerate(out):
            if np.allclose(other.values, curve.values, rtol=0.0, atol=1e-3, equal_nan=True):
                wider = max(other, curve, key=lambda c: c.width)
                out[j] = replace(wider, name=f"{other.name}, {curve.name}")
                break
        else:
            out.append(curve)
    return out


def faults(bits: Array) -> list[Curve]:
    """One curve for each fault that is ever set, one above the other."""
    seen = int(np.bitwise_or.reduce(bits, initial=0))
    ever = [(name, bit) for name, bit in FAULTS.items() if seen & bit]
    return [
        Curve(name, COLOURS[j % len(COLOURS)], j + 0.8 * (bits & bit != 0), 2.0)
        for j, (name, bit) in enumerate(ever)
    ]


def events(
    t: Trace,
) -> tuple[list[tuple[float, float, str, str]], list[tuple[float, str, str]]]:
    """Bands and marks of a run: start, recovery, verdict of lost lock, alarms."""
    bands = []
    for key, text, colour in (("starting", "start", "faint"), ("recovering", "recovery", "bad")):
        edges = np.diff((t[key] > 0.0).astype(np.int8), prepend=0, append=0)
        for a, b in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
            bands.append((float(t["t"][a]), float(t["t"][b - 1]), text, colour))
    what = "lost" if np.isinf(t["twin_fails"][-1]) else "not feasible"
    marks = [(float(t["t"][t["judged"]][0]), what, "text")] if t["judged"].any() else []
    alarms = np.flatnonzero(np.diff(t["alarm"].astype(np.int8), prepend=0) == 1)
    word = "alarm" if len(alarms) == 1 else f"alarm, first of {len(alarms)}"
    return bands, marks + [
        (float(t["t"][j]), "" if k else word, "bad") for k, j in enumerate(alarms)
    ]

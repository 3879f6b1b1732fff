"""Curves of a machine's check for its page: what it reaches, and what injection sees."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.machine.magnetics import flux, torque_of
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import polar, top_speeds
from sensorless.suitability.seen import Seen
from sensorless.units import RAD_S_TO_RPM

POINTS = 150
"""Speeds of the reach, to half again the rated one."""
CURRENT = "current on the line of maximum torque per ampere [A]"

Panel = dict[str, Any]
"""A plot in JSON types."""


def _curve(name: str, values: Array | Sequence[float | None], colour: str, **more: Any) -> Panel:
    """One curve; it has a gap where a value is not finite."""
    known = [None if v is None or not np.isfinite(v) else float(v) for v in values]
    return {"name": name, "values": known, "colour": colour, "width": 1.8, **more}


def _panel(label: str, x: Array, x_label: str, curves: Sequence[Panel], **more: Any) -> Panel:
    known = [v for curve in curves for v in curve["values"] if v is not None]
    span = [1.06 * min(0.0, *known), 1.06 * max(0.0, *known) or 1.0]  # zero is always on it
    return {
        "label": label, "x": x.tolist(), "xLabel": x_label, "curves": curves, "span": span, **more
    }  # fmt: skip


def reach(motor: Motor) -> Panel:
    """Largest torque over speed within rated and within largest current, and the rated point."""
    i = polar(motor)
    psi = flux(motor.saturation, i)
    tau = torque_of(motor.n_p, psi, i)
    top = top_speeds(motor, i, psi) / motor.n_p * RAD_S_TO_RPM
    size = np.hypot(*i.T)
    speed = np.linspace(0.0, 1.5 * motor.n_rated_rpm, POINTS + 1)  # two thirds are the rated one
    curves = []
    for limit, colour, label in (
        (motor.i_max, "observer", "i_max"),
        (motor.i_rated, "hfi", "i_rated"),
    ):
        inside = size <= (1.0 + 1e-9) * limit
        best = _most(tau[inside], top[inside], speed)
        curves.append(_curve(f"{label} = {limit:g} A", best, colour))
    point: list[float | None] = [None] * len(speed)
    point[2 * POINTS // 3] = motor.tau_rated
    curves.append(_curve("rated point", point, "own", points=True))
    return _panel("torque [N m]", speed, "speed [r/min]", curves)


def _most(tau: Array, top: Array, speed: Array) -> Array:
    """Largest torque at each speed, between the points that no other one beats in both."""
    order = np.argsort(-top, kind="stable")
    best = np.maximum.accumulate(tau[order])
    front = np.flatnonzero(np.diff(best, prepend=0.0) > 0.0)[::-1]
    return np.asarray(np.interp(speed, top[order][front], best[front], right=0.0))


def signal(motor: Motor, seen: Seen) -> list[Panel]:
    """Inductance ratio, cross-coupling, and the angle's noise over the current."""
    s, size = seen.signal, np.hypot(*seen.signal.i.T)
    panels = (
        ("inductance ratio L_q / L_d", [("ratio", s.ratio, "observer")]),
        ("cross-coupling [° el.]", [("turn of the magnetic axes", seen.cross_deg, "hfi")]),
        (
            "angle noise [° el.]",
            [("RMS", s.noise_deg, "own"), ("one step of the converter", s.step_deg, "ref")],
        ),
    )
    rated = [[motor.i_rated, "rated current", "muted"]]
    return [
        _panel(label, size, CURRENT, [_curve(*curve) for curve in curves], marks=rated)
        for label, curves in panels
    ]

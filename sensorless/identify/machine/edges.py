"""Voltage that the legs lose in a period of a pulse, from their currents at the switching edges.

A pulse moves the current by much in a period, so the samples do not say which way it flows through
a leg when that leg switches. The command does, by ``core/sim/edges.h``: the inverse inductance
turns it into a slope of the current, and what the samples show beyond that is spread evenly.
"""

from dataclasses import replace

import numpy as np

from sensorless.core.api import Array
from sensorless.core.machine import SLOPE, edge_losses
from sensorless.identify.machine.electric import Stator, parts, plane
from sensorless.identify.machine.pulses import Group
from sensorless.machine.magnetics import flux, inverse_inductance
from sensorless.machine.motor import Saturation


def at_edges(g: Group, stator: Stator, model: Saturation, most: float) -> Group:
    """The group with lost voltages from its edges; ``most``: current that the model covers [A]."""
    between = 0.5 * (g.i[1:] + g.i[:-1])
    between = between * np.minimum(1.0, most / np.maximum(np.abs(between), 1e-12))
    psi = flux(model, parts(between))
    back = np.exp(1j * g.theta)  # to the stator frame, which has the phases
    lost = edge_losses(
        _slope(inverse_inductance(model, psi), g, back),
        parts(g.u * back),
        parts(g.i[:-1] * back),
        g.u_dc,
        stator.inverter.u_lost,
        g.T_s,
    ).astype(float)
    return replace(g, lost=plane(lost) / back)


def _slope(gamma: Array, g: Group, back: complex) -> Array:
    """Slope of the current in every period: ``gamma`` (n, 2, 2) [1/H] turned, and the rest."""
    turn = np.array([[back.real, -back.imag], [back.imag, back.real]])
    turned = turn @ gamma @ turn.T
    driven = np.einsum("nij,nj->ni", gamma, parts(g.u))
    rest = ((g.i[1:] - g.i[:-1]) / g.T_s - plane(driven)) * back
    out = np.zeros(len(g.u), dtype=SLOPE)
    out["aa"], out["ab"], out["bb"] = turned[:, 0, 0], turned[:, 0, 1], turned[:, 1, 1]
    out["drift_a"], out["drift_b"] = rest.real, rest.imag
    return out

"""Voltage that the legs lose in a period of a pulse, from their currents at the switching edges.

A pulse moves the current by much in a period, so the samples do not say which way it flows through
a leg when that leg switches. The command does: with pulses symmetric about the middle of the period
leg j rises at t_j = T (1/2 - u_j / u_dc) / 2 and falls at T - t_j; until then each leg m above it
has put T (u_m - u_j) / 2 on its phase. The inverse inductance turns that into a current, and what
the samples show beyond it is spread evenly. Below 2/3 gamma u_lost T, gamma the leg's own inverse
inductance, dead time stops a current and cannot reverse it: there the loss is linear, as in
``core/sim/edges.h``.
"""

from dataclasses import replace

import numpy as np

from sensorless.identify.machine.electric import DIRECTIONS, Complex, Stator
from sensorless.identify.machine.pulses import Group
from sensorless.machine.magnetics import Floats, flux, inverse_inductance
from sensorless.machine.motor import Saturation


def at_edges(g: Group, stator: Stator, model: Saturation, most: float) -> Group:
    """The group with lost voltages from its edges; ``most``: current that the model covers [A]."""
    between = 0.5 * (g.i[1:] + g.i[:-1])
    between = between * np.minimum(1.0, most / np.maximum(np.abs(between), 1e-12))
    psi = flux(model, np.stack([between.real, between.imag], axis=-1))
    gamma = inverse_inductance(model, psi)
    phases = DIRECTIONS * np.exp(-1j * g.theta)
    legs = (g.u[:, None] * phases.conj()).real
    legs = legs - 0.5 * (legs.max(axis=1) + legs.min(axis=1))[:, None]
    rest = (g.i[1:] - g.i[:-1]) - _current(gamma, g.u * g.T_s)
    lost = np.zeros(len(g.u), complex)
    for leg, phase in zip(legs.T, phases, strict=True):
        share = 0.5 * np.clip(0.5 - leg / np.maximum(g.u_dc, 1.0), 0.0, 1.0)
        above = np.maximum(legs - leg[:, None], 0.0)
        before = _current(gamma, g.T_s / 3.0 * (above @ phases)) + rest * share
        own = (_current(gamma, np.full(len(leg), phase)) / phase).real
        zero = np.maximum(2.0 / 3.0 * own * stator.inverter.u_lost * g.T_s, 1e-9)
        edges = ((i / phase).real / zero for i in (g.i[:-1] + before, g.i[1:] - before))
        way = sum(0.5 * np.clip(x, -1.0, 1.0) for x in edges)
        lost += 2.0 / 3.0 * stator.inverter.u_lost * way * phase
    return replace(g, lost=lost)


def _current(gamma: Floats, linked: Complex) -> Complex:
    """Change of the current [A] by flux linkages (n,) [Vs] through inverse inductances."""
    i = np.einsum("nij,nj->ni", gamma, np.stack([linked.real, linked.imag], axis=-1))
    return np.asarray(i[:, 0] + 1j * i[:, 1])

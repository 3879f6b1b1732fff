"""Flux linkage over current from voltage pulses at rest (doi 10.1109/TIA.2016.2644624).

A voltage along a direction reverses whenever the current along it reaches a limit, so that neither
the magnet's torque nor the speed that it gives has a mean. The flux linkage is the integral of the
voltage behind the resistance. It starts from the small current's inductance and has to come back
there at the end; what is left over is spread evenly in time.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from sensorless.identify.machine.axis import (
    OFF_AXIS,
    Aligned,
    Axis,
    align_commands,
    fit_axis,
    probe_commands,
)
from sensorless.identify.machine.electric import Complex, Stator, rms
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Command, Source, volts
from sensorless.machine.magnetics import Floats

GROUPS = (
    (0.0, 180.0), (90.0, -90.0), (45.0,), (-45.0,), (67.5,), (-67.5,), (25.0,), (-25.0,)
)  # fmt: skip
"""Directions of the pulses from the d axis [deg], those that follow each other at a time.

The largest current is the other way round: where it weakens the magnet, in both quadrants."""
REACH = 1.05
"""Current at which the voltage reverses, over rated current."""
PLACES = (np.pi / 12.0, -np.pi / 12.0)
"""Places of the rotor [rad]: saliency that turns six times as fast has opposite signs there."""
SLOWER = (1.0, 3.0, 9.0)
"""Factors on the times of an alignment that are tried until the rotor gets there."""
LEFT, OUTLIER = 0.05, 3.0
"""Most flux left over at the end of a pulse over its largest, or over the groups' median."""
LOBES = (0.5**0.5, 1.0, 0.5**0.5, 1e-3)
"""Currents at which the voltage reverses over ``REACH``.

The impulse of a lobe of current grows with its height squared: the first gives the rotor a speed,
the second turns it round, the third stops it where it was."""
STEP = 0.1
"""Change of the current in a period that is aimed at, over rated current."""
FAST, ENOUGH = 4.0, 1.25
"""Voltage of a fast pulse over that of rated current, least voltage over that of ``REACH``."""
OVERSHOOT = 3.0
"""Changes in a period that fit between ``REACH`` and the limit of the current: a sample sees it up
to one late, the voltage reverses a period later, and saturation makes both larger."""
MOST_VOLTAGE = 0.9
"""Of the pulses, over the largest phase voltage."""
ROUNDS = 4
"""Passes in which the flux linkage and the motion that its torque causes find each other."""


@dataclass(frozen=True)
class Group:
    """Pulses one after the other on a rotor that was at rest, in its frame at their start."""

    place: float
    """where the rotor was turned to [rad]"""
    theta: float
    """of that frame [rad]"""
    i: Complex
    """(n,) current [A]"""
    u: Complex
    """(n - 1,) voltage commanded between the samples [V]"""
    u_dc: Floats
    """(n - 1,) DC link [V]"""
    R_s: float
    """[ohm]"""
    lost: Complex
    """(n - 1,) voltage that the inverter loses [V]"""
    bounds: tuple[int, ...]
    """rows at which a pulse starts or ends"""
    small: tuple[float, float]
    """L_d and L_q at small current [H]"""
    T_s: float

    @property
    def path(self) -> Complex:
        """(n,) integral of the voltage behind resistance and lost voltage [Vs]."""
        e = self.u - self.lost - 0.5 * self.R_s * (self.i[1:] + self.i[:-1])
        return np.asarray(np.r_[0.0, np.cumsum(e) * self.T_s])


@dataclass(frozen=True)
class Samples:
    """Flux linkage over current in the rotor frame."""

    i: Complex
    """(n,) d + j q [A]"""
    psi: Complex
    """(n,) less the magnet's [Vs]"""
    left: float
    """RMS of what was left over at the ends of pulses over their largest flux"""
    turned: float
    """largest turn of the rotor [rad]"""


def measure_pulses(
    source: Source, stator: Stator, plate: Nameplate, aligned: Aligned
) -> list[Group]:
    """Align, find the axis, pulse, at each place for each group of directions."""
    out = []
    for at in PLACES:
        slower = list(SLOWER)
        for group in GROUPS:
            axis = placed(source, stator, plate, aligned, at, slower)
            part = source.run("pulse", list(_commands(group, axis, stator, plate)))
            out.append(_integrated(part, at, axis, stator))
    return out


def placed(
    source: Source,
    stator: Stator,
    plate: Nameplate,
    aligned: Aligned,
    at: float,
    slower: list[float],
) -> Axis:
    """Turn the rotor to ``at`` and find its axis; more slowly, if it does not get there.

    Where a leg carries no current, dead time blocks the current that damps the rotor's swing, so
    the turn itself must not excite one. What failed is taken off ``slower``, except for the last.
    """
    while True:
        stretch = slower[0] * aligned.stretch
        source.run("align", align_commands(stator, plate, aligned.current, stretch, at=at))
        axis = fit_axis(source.run("axis", probe_commands(aligned.probe, plate.T_s)), stator)
        off = 0.5 * abs(np.angle(np.exp(2j * (axis.theta - at))))
        if off <= OFF_AXIS or len(slower) == 1:
            return axis
        del slower[0]


def _commands(
    group: tuple[float, ...], axis: Axis, stator: Stator, plate: Nameplate
) -> Iterator[Command]:
    reach = REACH * plate.i_rated
    for phi in np.deg2rad(group):
        gamma = axis.mean + axis.half * np.cos(2.0 * phi)
        u = voltage(gamma, stator, plate)
        time = 10.0 * plate.i_rated / (gamma * u)
        theta = float(axis.theta + phi)
        for number, share in enumerate(LOBES):
            yield volts(time, (-1.0) ** number * u, theta, until=share * reach)
    yield volts(2.0 * plate.T_s, 0.0)


def voltage(gamma: float, stator: Stator, plate: Nameplate) -> float:
    """Voltage of a pulse [V] where the inverse inductance is ``gamma`` [1/H]."""
    step, reach = gamma * plate.T_s, REACH * plate.i_rated
    lost = stator.inverter.u_lost
    u = max(STEP * plate.i_rated / step, FAST * stator.R_s * plate.i_rated + 2.0 * lost)
    u = min(u, (plate.i_limit - reach) / (OVERSHOOT * step))
    u = max(u, ENOUGH * (stator.R_s * reach + 4.0 / 3.0 * lost))
    return min(u, MOST_VOLTAGE * plate.u_base)


def _integrated(part: Part, at: float, axis: Axis, stator: Stator) -> Group:
    """Pulses of a part, each of as many commands as lobes, without the decay after them."""
    turn = np.exp(-1j * axis.theta)
    segment = part["segment"]
    last = int(segment.max())
    bounds = [int(np.argmax(segment >= k)) for k in range(0, last + 1, len(LOBES))]
    n = bounds[-1] + 1
    i = stator.sensors.current(part)[:n]
    return Group(
        place=at,
        theta=axis.theta,
        i=i * turn,
        u=part.u[: n - 1] * turn,
        u_dc=part["u_dc"][: n - 1],
        R_s=stator.R_s,
        lost=stator.lost(i) * turn,
        bounds=tuple(bounds),
        small=(axis.L_d, axis.L_q),
        T_s=stator.T_s,
    )


def samples(groups: Sequence[Group], psi_f: float, turn: float) -> Samples:
    """Flux linkages of all pulses, with the motion that their torque causes.

    Parameters
    ----------
    psi_f : float
        Magnet flux [Vs].
    turn : float
        Electrical acceleration over psi x i, 3/2 n_p^2 / J [rad/s^2 per V s A]; 0: none.
    """
    parts = [_moved(g, psi_f, turn) for g in groups]
    worst = np.array([part[2].max() for part in parts])
    # a group that began on a rotor in motion does not come back to where it began
    sound = worst <= max(LEFT, OUTLIER * float(np.median(worst)))
    parts = [part for part, keep in zip(parts, sound, strict=True) if keep]
    i, psi, left, theta = (np.concatenate(x) for x in zip(*parts, strict=True))
    return Samples(i, psi, rms(left), float(np.abs(theta).max()))


def _moved(g: Group, psi_f: float, turn: float) -> tuple[Complex, Complex, Floats, Floats]:
    theta = np.zeros(len(g.i))
    for _ in range(ROUNDS if turn else 1):
        psi, left = closed(g, psi_f, theta)
        speed = np.cumsum(turn * (psi.conj() * g.i).imag) * g.T_s
        theta = np.r_[0.0, np.cumsum(speed[:-1]) * g.T_s]
    psi, left = closed(g, psi_f, theta)
    back = np.exp(-1j * theta)
    return g.i * back, psi * back - psi_f, left, theta


def closed(g: Group, psi_f: float, theta: Floats) -> tuple[Complex, Floats]:
    """Flux linkage in the frame at the start that is the small current's where a pulse ends."""
    psi, left = np.zeros(len(g.i), complex), []
    for a, b in zip(g.bounds, g.bounds[1:], strict=False):
        ends = []
        for k in (a, b):
            turn = np.exp(1j * theta[k])
            i = g.i[k] / turn
            ends.append((psi_f + g.small[0] * i.real + 1j * g.small[1] * i.imag) * turn)
        path = g.path[a : b + 1] - g.path[a]
        gap = path[-1] - (ends[1] - ends[0])
        psi[a : b + 1] = ends[0] + path - gap * np.linspace(0.0, 1.0, b + 1 - a)
        left.append(abs(gap) / np.abs(path).max())
    return psi, np.array(left)

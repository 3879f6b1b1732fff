"""Where the rotor stands, and its inductances at small current.

At rest di/dt = g e + G exp(2 j theta) conj(e) with e the voltage behind the resistance,
g = (1/L_d + 1/L_q) / 2, G = (1/L_d - 1/L_q) / 2 and theta the d axis. Short voltage pulses in three
directions, each as often backwards as forwards, give the three numbers by least squares, theta
except for half a turn. A direct current before them turns the magnet to phase a and settles that.
"""

from dataclasses import dataclass, replace

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.electric import Stator, windows
from sensorless.identify.machine.hold import quarter
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import VOLTAGE, Command, Source, volts

PEAK = 0.15
"""Current that the pulses reach over rated current."""
MOST_VOLTAGE = 0.5
"""Of the pulses, over the largest phase voltage."""
REPEATS = 4
ALIGN = (0.5, 0.35, 0.25, 0.18, 0.12, 0.08)
"""Direct currents that are tried to turn the magnet, over rated current.

With more than psi_f / (L_q - L_d) the reluctance turns the rotor off the current."""
OFF_AXIS = 0.08
"""Angle between current and d axis that counts as aligned; twice that, if none is better [rad]."""
MOVES = 0.02
"""Change of the current over itself at which the rotor still moves."""
REST, DECAY = 0.4, 0.1
"""Times of an alignment: at rest, without voltage [s]."""


@dataclass(frozen=True)
class Probe:
    """Size of the pulses."""

    u: float
    """[V]"""
    n: int
    """periods"""


@dataclass(frozen=True)
class Axis:
    """Result of the pulses."""

    theta: float
    """d axis in [-pi/2, pi/2] [rad]"""
    mean: float
    """g [1/H]"""
    half: float
    """G [1/H]"""

    @property
    def L_d(self) -> float:
        """Inductance of the d axis [H]."""
        return 1.0 / (self.mean + self.half)

    @property
    def L_q(self) -> float:
        """Inductance of the q axis [H]."""
        return 1.0 / (self.mean - self.half)


def probe_commands(p: Probe, T_s: float) -> list[Command]:
    """Pulses in three directions, forwards and backwards."""
    out = []
    for sign in REPEATS * (1.0, -1.0):
        for theta in np.pi / 3.0 * np.arange(3):
            u = sign * p.u
            out += [volts(n * p.n * T_s, s * u, theta) for n, s in ((1, 1.0), (2, -1.0), (1, 1.0))]
    return [*out, volts(4 * T_s, 0.0)]


def fit_axis(part: Part, stator: Stator) -> Axis:
    """Least squares over all periods of the pulses."""
    i, e = stator.emf(part)
    di = np.diff(i) / stator.T_s
    ec = e.conj()
    # real and imaginary parts of g e + (c + j s) conj(e)
    top = np.stack([e.real, ec.real, -ec.imag], axis=-1)
    low = np.stack([e.imag, ec.imag, ec.real], axis=-1)
    g, c, s = np.linalg.lstsq(np.r_[top, low], np.r_[di.real, di.imag], rcond=None)[0]
    return Axis(0.5 * float(np.arctan2(s, c)), float(g), float(np.hypot(c, s)))


def find_probe(source: Source, stator: Stator, plate: Nameplate) -> Probe:
    """Raise the pulses until they reach ``PEAK``.

    Raises
    ------
    UserError
        The largest pulses give hardly any current.
    """
    u, n = 0.05 * plate.u_base, 1
    for _ in range(12):
        part = source.run("probe", probe_commands(Probe(u, n), plate.T_s))
        peak = float(np.abs(stator.sensors.current(part)).max()) / plate.i_rated
        if peak >= 0.7 * PEAK:
            return Probe(u, n)
        u *= float(np.clip(PEAK / max(peak, 1e-6), 1.0, 3.0))
        if u > MOST_VOLTAGE * plate.u_base:
            u, n = MOST_VOLTAGE * plate.u_base * n / (n + 1), n + 1
    raise UserError("inductance: pulses of half the voltage give hardly any current; check T_s")


def align_commands(
    stator: Stator,
    plate: Nameplate,
    i: float,
    stretch: float,
    side: float = 1.0,
    at: float = 0.0,
) -> list[Command]:
    """Pull the magnet to a right angle, then slowly to ``at`` [rad], and let the current decay.

    ``side``: of which sign the right angle is.
    """
    current = i * np.exp(1j * at)
    vector = stator.R_s * current + stator.inverter.lost(np.array([current]))[0]
    u, at = float(abs(vector)), float(np.angle(vector))
    turn = stretch * quarter(plate, stator.R_s * i)
    speed = -side * 0.5 * np.pi / turn
    return [
        volts(turn, u, at + side * 0.5 * np.pi),
        Command(VOLTAGE, turn, u, omega=(0.0, speed)),
        Command(VOLTAGE, turn, u, omega=(speed, 0.0)),
        volts(stretch * REST, u, at),
        volts(DECAY, 0.0),
    ]


@dataclass(frozen=True)
class Aligned:
    """How the rotor gets to phase a."""

    probe: Probe
    current: float
    """direct current that aligns [A]"""
    stretch: float
    """factor on the times of the alignment"""
    axis: Axis


def _moves(part: Part, stator: Stator, stretch: float) -> float:
    """Change of the current [A] in the last half of the rest: the EMF of a rotor that moves."""
    rest = windows(part, 0.5 * stretch * REST, stator.T_s)[-2]
    first, last = np.array_split(stator.sensors.current(part)[rest], 2)
    return float(abs(first.mean() - last.mean()))


def align(source: Source, stator: Stator, plate: Nameplate) -> Aligned:
    """Find a direct current that turns the magnet to phase a, and the rotor there.

    Raises
    ------
    UserError
        No current aligns the rotor.
    """
    probe: Probe | None = None
    tried: list[tuple[float, Aligned]] = []
    for rank, share in enumerate(ALIGN):
        for stretch in (1.0, 3.0, 9.0):
            current = share * plate.i_rated
            axes: list[Axis] = []
            for side in (1.0, -1.0):  # a rotor in between shows from one of them
                part = source.run("align", align_commands(stator, plate, current, stretch, side))
                moves = _moves(part, stator, stretch) > MOVES * current
                probe = probe or find_probe(source, stator, plate)
                axes.append(fit_axis(source.run("axis", probe_commands(probe, plate.T_s)), stator))
                if moves or abs(axes[-1].theta) > OFF_AXIS:
                    break
            assert probe is not None
            found = Aligned(probe, current, stretch, axes[-1])
            tried.append((abs(found.axis.theta), found))
            if len(axes) == 2 and not moves and abs(found.axis.theta) <= OFF_AXIS:
                # where a larger current has failed, this one is close to it: take the next smaller
                least = rank == 0 or share == ALIGN[-1]
                return found if least else replace(found, current=ALIGN[rank + 1] * plate.i_rated)
            if not moves:
                break
    off, best = min(tried, key=lambda x: x[0])
    if off < 2.0 * OFF_AXIS:
        return best
    raise UserError(
        f"rotor: no direct current turns it to phase a (it stays {np.rad2deg(off):.0f} degrees "
        f"off; L_q / L_d = {best.axis.L_q / best.axis.L_d:.3g}); free the shaft, and check that "
        "the machine has magnets and saliency"
    )

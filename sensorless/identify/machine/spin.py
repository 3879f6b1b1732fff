"""Magnet flux, inertia and friction from a spin on a turning current.

The rotor follows a current that turns without any estimate of its angle. In the frame of that
current the flux linkage psi is the voltage behind the resistance over j omega. Its part along the
current is psi_f plus what the current itself makes; the lost voltage is along the current and the
EMF is not, so neither dead time nor resistance enters. The part across the current is the torque,
tau = 3/2 n_p Im(conj(psi) i).
"""

from dataclasses import dataclass, replace

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.axis import Aligned, align_commands
from sensorless.identify.machine.curves import Curves
from sensorless.identify.machine.electric import Complex, Stator, rms, windows
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.mechanics import Mechanics, fit_mechanics
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Gains, Source
from sensorless.identify.machine.turning import HOLD, START, first_spin, second_spin
from sensorless.machine.magnetics import Floats

RAMPS = (1.0, 3.0, 9.0)
"""Times of the first ramp that are tried [s]."""
BANDWIDTH = 0.06
"""Of the current control, times the PWM period."""
ROUNDS = 30
"""Of angle and L_q from each other."""
FLUTTER = 0.15
"""Most change of the flux at constant speed over its mean: beyond, the rotor does not follow."""


@dataclass(frozen=True)
class Point:
    """Flux linkage at constant speed and current."""

    omega: float
    """electrical [rad/s]"""
    i: float
    """current [A]"""
    blocks: tuple[Complex, Complex]
    """currents [A] and flux linkages [Vs], each the mean of a sixth of a turn"""
    flutter: float
    """standard deviation of the flux over its mean"""
    psi_f: float
    """[Vs]"""


@dataclass(frozen=True)
class Spin:
    """Result of a spin."""

    points: tuple[Point, ...]
    mechanics: Mechanics
    aligns: float
    """current up to which the magnet is along the current [A]"""

    @property
    def used(self) -> list[Point]:
        """Points that tell the magnet: those within that current."""
        return [p for p in self.points if p.i <= 1.05 * self.aligns]

    def again(self, curves: Curves, g: float = 0.0) -> "Spin":
        """Evaluate the points with other curves; ``g``: conductance of the iron's loss [S]."""
        points = []
        for p in self.points:
            i, psi = p.blocks
            made = i - 1j * g * p.omega * psi  # without the current of the loss, across the EMF
            points.append(replace(p, psi_f=float(magnet(psi, made, curves).mean())))
        return replace(self, points=tuple(points))

    @property
    def psi_f(self) -> float:
        """Mean over the points in use [Vs]."""
        return float(np.mean([p.psi_f for p in self.used]))

    @property
    def psi_f_std(self) -> float:
        """Spread of the points in use [Vs]."""
        return float(np.std([p.psi_f for p in self.used]))


def measure_spin(
    source: Source, stator: Stator, plate: Nameplate, curves: Curves, aligned: Aligned
) -> Spin:
    """Spin slowly and carefully, then faster with ramps that the first spin's result allows.

    Raises
    ------
    UserError
        The rotor does not follow the current.
    """
    L = float(np.sqrt(aligned.axis.L_d * aligned.axis.L_q))
    gains = Gains(stator.R_s, L, BANDWIDTH / plate.T_s)
    begin = align_commands(stator, plate, aligned.current, aligned.stretch)
    first = None
    for ramp in RAMPS:
        source.run("align", begin)
        part = source.run("start", first_spin(plate, aligned.current, ramp), gains)
        first = evaluate(part, stator, plate, curves, aligned.current)
        if first is not None:
            break
    if first is None:
        raise UserError(
            "spin: the rotor does not follow a slowly turning current; free it from its load, and "
            "check the pole pairs"
        )
    for careful in (1.0, 3.0):
        source.run("align", begin)
        part = source.run(
            "spin", second_spin(plate, first.mechanics.J, aligned.current, careful), gains
        )
        found = evaluate(part, stator, plate, curves, aligned.current)
        if found is not None:
            return found
    raise UserError("spin: the rotor falls out of step; check the name plate's speed")


def flux_in_frame(part: Part, stator: Stator) -> tuple[Complex, Complex]:
    """Currents [A] and flux linkages [Vs] in the frame of the drive's own angle, (n - 1,) each.

    At constant speed psi(k+1) - psi(k) = psi(k) (exp(j omega T_s) - 1).
    """
    i, e = stator.emf(part)
    turn = np.exp(-1j * part["theta"][:-1])
    step = np.exp(1j * part["omega"][:-1] * stator.T_s) - 1.0
    step = np.where(np.abs(step) < 1e-9, np.inf, step)
    return i[:-1] * turn, np.asarray(e * turn * stator.T_s / step)


def evaluate(
    part: Part, stator: Stator, plate: Nameplate, curves: Curves, aligns: float
) -> Spin | None:
    """Magnet flux and mechanics of a part; None if the rotor did not follow."""
    i, psi = flux_in_frame(part, stator)
    omega = part["omega"][:-1]
    points = []
    for w in windows(part, 0.75 * HOLD, stator.T_s):
        w = slice(w.start, min(w.stop, len(psi)))
        if w.stop - w.start < 2:
            continue  # a test that stopped at the current limit
        a, b = (float(x.mean()) for x in np.array_split(omega[w], 2))
        if abs(b - a) > 0.02 * plate.omega or a < 0.5 * START * plate.omega:
            continue
        sixth = round(np.pi / (3.0 * a * stator.T_s))
        psi_w, i_w = blocks(psi[w], sixth), blocks(i[w], sixth)
        if np.ptp(np.abs(i_w)) > 0.05 * plate.i_rated:
            continue  # the current is on its way to another size
        flutter = rms(psi_w - psi_w.mean()) / abs(psi_w.mean())
        points.append(
            Point(
                a,
                float(abs(i_w.mean())),
                (i_w, psi_w),
                flutter,
                float(magnet(psi_w, i_w, curves).mean()),
            )
        )
    mechanics = fit_mechanics(i, psi, omega, part["segment"][:-1], plate, stator.T_s)
    follows = bool(points) and all(p.flutter < FLUTTER for p in points)
    if not follows or mechanics.J <= 2.0 * mechanics.J_std:
        return None
    return Spin(tuple(points), mechanics, aligns)


def magnet(psi: Complex, i: Complex, curves: Curves) -> Floats:
    """Magnet flux [Vs] from fluxes and currents (n,) in any common frame.

    psi - L_q i, L_q that of the q axis, is along the d axis (the active flux, doi
    10.1109/TIE.2008.2003497); its angle and L_q follow from each other in a few rounds.
    """
    angle = np.angle(psi)
    for _ in range(ROUNDS):
        psi_q = curves.psi(i * np.exp(-1j * angle)).imag
        # psi turned by the angle has the q part psi_q
        angle = np.angle(psi) - np.arcsin(np.clip(psi_q / np.abs(psi), -1.0, 1.0))
    back = np.exp(-1j * angle)
    return np.asarray((psi * back).real - curves.psi(i * back).real)


def blocks(x: Complex, n: int) -> Complex:
    """Means of n numbers each; what is left at the end is dropped."""
    n = max(1, min(n, len(x)))
    m = len(x) // n
    return np.asarray(x[: m * n].reshape(m, n).mean(axis=1))

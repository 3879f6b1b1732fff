"""Magnet flux, inertia and friction from a spin on a turning current.

The rotor follows a current that turns without any estimate of its angle. In the frame of that
current the flux linkage psi is the voltage behind the resistance over j omega. Its part along the
current is psi_f plus what the current itself makes; the lost voltage is along the current and the
EMF is not, so neither dead time nor resistance enters. The part across the current is the torque,
tau = 3/2 n_p Im(conj(psi) i), and J d omega_m/dt = tau - B omega_m - tau_0.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from sensorless.errors import UserError
from sensorless.identify.machine.axis import Aligned, align_commands
from sensorless.identify.machine.curves import Curves
from sensorless.identify.machine.electric import Complex, Stator, rms, windows
from sensorless.identify.machine.log import Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Command, Gains, Source, amps
from sensorless.machine.magnetics import Floats

RAMP_CURRENT = 0.5
"""While the speed changes, over rated."""
CURRENTS = (0.8, 0.6)
"""While the magnet is measured, over the current that aligns: more turns the rotor off it."""
SLOW, FAST = 0.2, 0.45
"""Speeds over rated."""
START = 0.2
"""Speed of the first, careful spin over rated."""
RAMPS = (1.0, 3.0, 9.0)
"""Times of the first ramp that are tried [s]."""
SHARE = 0.12
"""Torque of the second ramps over rated."""
GUESS = 0.2
"""Time in which rated torque brings the rotor to rated speed, before it is known [s]."""
STIFF = 0.4
"""Torque a radian between rotor and current over rated, for the time of a swing."""
HOLD = 0.4
"""Least time at a speed [s]."""
BANDWIDTH = 0.06
"""Of the current control, times the PWM period."""
ROUNDS = 30
SLOWEST = 0.25
"""Least speed over the largest at which the torque is measured."""
STILL = 0.03
"""Most change of a constant speed over the largest: the damping moves it a little."""
ENDS = 3
"""Sixths of a turn over which the speed at the end of a stretch is averaged."""
TURNS = 3.2
"""Least electrical turns at a speed."""
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
class Mechanics:
    """Least squares on the torque."""

    J: float
    """[kg m^2]"""
    J_std: float
    B: float
    """[N m s/rad]"""
    tau_0: float
    """friction that does not depend on speed [N m]"""
    residual: float
    """RMS of the torque left over [N m]"""


NO_MECHANICS = Mechanics(0.0, math.inf, 0.0, 0.0, math.inf)
"""Too little was measured."""


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

    def again(self, curves: Curves) -> "Spin":
        """Evaluate the points with other curves."""
        points = tuple(
            replace(p, psi_f=float(magnet(p.blocks[1], p.blocks[0], curves).mean()))
            for p in self.points
        )
        return replace(self, points=points)

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
        part = source.run("start", _first(plate, ramp), gains)
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
            "spin", _second(plate, first.mechanics.J, aligned.current, careful), gains
        )
        found = evaluate(part, stator, plate, curves, aligned.current)
        if found is not None:
            return found
    raise UserError("spin: the rotor falls out of step; check the name plate's speed")


def _begin(i: float) -> list[Command]:
    return [amps(0.1, 0.0, 0.0, end=i), amps(0.3, i)]


@dataclass(frozen=True)
class _Turning:
    """Makes commands at the ramps' current for a rotor of a certain inertia."""

    plate: Nameplate
    J: float

    @property
    def i(self) -> float:
        return RAMP_CURRENT * self.plate.i_rated

    @property
    def swing(self) -> float:
        """Frequency at which the rotor swings about the current [rad/s]."""
        return float(np.sqrt(self.plate.n_p * STIFF * self.plate.tau_rated / self.J))

    def amps(
        self, time: float, omega: tuple[float, float], start: float, end: float | None = None
    ) -> Command:
        """Damped by half: d u / d delta = omega d tau / d delta / (3/2 n_p i)."""
        p = self.plate
        slope = max(omega) * STIFF * p.tau_rated / (1.5 * p.n_p * self.i)
        follow = 0.2 * self.swing * p.T_s
        return amps(time, start, end=end, omega=omega, damp=self.swing / slope, follow=follow)

    def ramp(self, time: float, a: float, b: float) -> Command:
        return self.amps(time, (a, b), self.i)

    def hold(self, omega: float, periods: float = 3.0) -> Command:
        time = max(HOLD, periods * 2.0 * np.pi / self.swing, TURNS * 2.0 * np.pi / omega)
        return self.amps(time, (omega, omega), self.i)


def _first(plate: Nameplate, ramp: float) -> list[Command]:
    t = _Turning(plate, GUESS * plate.tau_rated * plate.n_p / plate.omega)
    top = START * plate.omega
    return [*_begin(t.i), t.ramp(ramp, 0.0, top), t.hold(top, 0.0), t.ramp(ramp, top, 0.0)]


def _second(plate: Nameplate, J: float, aligns: float, careful: float) -> list[Command]:
    t = _Turning(plate, J)
    period = 2.0 * np.pi / t.swing
    slope = SHARE * plate.tau_rated * plate.n_p / J / careful
    low, high = SLOW * plate.omega, FAST * plate.omega

    def ramp(a: float, b: float) -> Command:
        return t.ramp(max(0.5 * np.pi * abs(b - a) / slope, 4.0 * careful * period), a, b)

    def magnet(omega: float) -> list[Command]:
        out, last, even = [], t.i, (omega, omega)
        for share in CURRENTS:
            out += [t.amps(period, even, last, share * aligns)]
            out += [t.amps(max(HOLD, TURNS * 2.0 * np.pi / omega), even, share * aligns)]
            last = share * aligns
        return [*out, t.amps(period, even, last, t.i), t.hold(omega, 1.0)]

    return [
        *_begin(t.i),
        ramp(0.0, high), t.hold(high), ramp(high, low), t.hold(low), ramp(low, high),
        t.hold(high), ramp(high, low), t.hold(low), *magnet(low),
        ramp(low, high), t.hold(high), *magnet(high), ramp(high, 0.0),
    ]  # fmt: skip


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


def fit_mechanics(
    i: Complex, psi: Complex, omega: Floats, segment: Floats, plate: Nameplate, T_s: float
) -> Mechanics:
    """Least squares of the torque on acceleration, speed and one.

    Means over stretches from the middle of a command at constant speed to that of the next: at both
    ends the rotor has the same angle to the current, so its speed is the current's.
    """
    tau = 1.5 * plate.n_p * (psi.conj() * i).imag
    turned = np.cumsum(np.abs(omega)) * T_s
    first = np.flatnonzero(np.diff(np.floor(turned / (np.pi / 3.0)))) + 1
    first = first[omega[first] > SLOWEST * omega.max()]
    if len(first) < 4 * ENDS:
        return NO_MECHANICS
    cuts = np.searchsorted(first, _cuts(omega, segment))
    cuts = np.unique(np.clip(np.r_[0, cuts, len(first) - 1], 0, len(first) - 1))
    rows = []
    for a, b in pairwise(cuts):
        if b - a < 2 * ENDS:
            continue
        speeds = [omega[first[k] : first[k + ENDS]].mean() / plate.n_p for k in (a, b - ENDS)]
        rows_in = slice(first[a], first[b])
        time = (first[b - ENDS] + first[b] - first[a] - first[a + ENDS]) * 0.5 * T_s
        mean = omega[rows_in].mean() / plate.n_p
        rows.append(((speeds[1] - speeds[0]) / time, 1.0, mean, tau[rows_in].mean()))
    known = 3 if len(rows) > 5 else 2  # a short spin does not tell the frictions apart
    if len(rows) <= known:
        return NO_MECHANICS
    table = np.array(rows)
    matrix, t = table[:, :known], table[:, 3]
    x = np.linalg.lstsq(matrix, t, rcond=None)[0]
    left = t - matrix @ x
    spread = np.linalg.pinv(matrix.T @ matrix)[0, 0] * (left @ left) / (len(t) - known)
    J, tau_0, B = (float(v) for v in np.r_[x, 0.0][:3])
    return Mechanics(J, float(np.sqrt(spread)), B, tau_0, rms(left))


def _cuts(omega: Floats, segment: Floats) -> Floats:
    """Rows at a third and two thirds of every command at constant speed."""
    out = []
    for command in np.unique(segment):
        rows = np.flatnonzero(segment == command)
        a, b = (x.mean() for x in np.array_split(omega[rows], 2))
        if abs(a - b) < STILL * omega.max():
            out += [rows[len(rows) // 3], rows[2 * len(rows) // 3]]
    return np.array(out, dtype=float)


def blocks(x: Complex, n: int) -> Complex:
    """Means of n numbers each; what is left at the end is dropped."""
    n = max(1, min(n, len(x)))
    m = len(x) // n
    return np.asarray(x[: m * n].reshape(m, n).mean(axis=1))

"""Inertia and friction from the torque of a spin: J d omega_m/dt = tau - B omega_m - tau_0."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from sensorless.identify.machine.electric import Complex, rms
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.machine.magnetics import Floats

SLOWEST = 0.25
"""Least speed over the largest at which the torque is measured."""
STILL = 0.03
"""Most change of a constant speed over the largest: the damping moves it a little."""
ENDS = 3
"""Sixths of a turn over which the speed at the end of a stretch is averaged."""
LONG = 5
"""Least stretches of a long spin."""


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
    if len(cuts) <= LONG:  # a short spin: its ramps count as far as they are fast
        cuts = np.r_[0, cuts, len(first)]
    cuts = np.unique(np.clip(cuts, 0, len(first) - 1))
    rows = []
    for a, b in pairwise(cuts):
        if b - a < 2 * ENDS:
            continue
        ends = [(int(first[k]), int(first[k + ENDS])) for k in (a, b - ENDS)]
        speeds = [float(omega[start:stop].mean()) / plate.n_p for start, stop in ends]
        begin, end = (sum(x) // 2 for x in ends)
        rows_in = slice(begin, end)
        time = (end - begin) * T_s
        mean = omega[rows_in].mean() / plate.n_p
        rows.append(((speeds[1] - speeds[0]) / time, 1.0, mean, tau[rows_in].mean()))
    known = 3 if len(rows) >= LONG else 2  # a short spin does not tell the frictions apart
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
        if len(rows) < 2:
            continue
        a, b = (x.mean() for x in np.array_split(omega[rows], 2))
        if abs(a - b) < STILL * omega.max() and b > SLOWEST * omega.max():
            out += [rows[len(rows) // 3], rows[2 * len(rows) // 3]]
    return np.array(out, dtype=float)

"""One fit over all pulses: the flux map and the inertia that explain them together.

In the frame of the rotor at the start of a pulse, the integral of the voltage behind resistance and
lost voltage is
    path = a + b t + (psi_f + psi(i exp(-j theta))) exp(j theta)
with a and b of each pulse free: noise at its start, and what is left of offsets or of a speed. The
rotor turns by theta = 3/2 n_p^2 / J times the double integral of Im(conj(path) i). psi is a model
plus a polynomial of both currents; the fit finds the polynomial and J by Gauss and Newton.

On pulses in q, a turn looks much like an inductance, so J is known from here only as well as the
rest of the pulse tells them apart. Therefore the spin's J takes part with its standard deviation,
the pulses with theirs: where a light rotor turns far, they say more; else the spin decides.
A rotor that swings before a pulse fits no J at all. Such a group is known by what it leaves over.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.identify.machine.curves import POWERS_D, POWERS_Q, powers
from sensorless.identify.machine.electric import Complex, rms
from sensorless.identify.machine.pulses import Group, Samples, closed
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Saturation

COVERED = 1.3
"""Current over rated up to which samples count."""
ROUNDS = 4
"""Of Gauss and Newton."""
OUTLIER = 3.0
"""Flux that a group leaves over, over the median's: beyond, its rotor was in motion."""
NOISE = 1e-3
"""First guess of the flux left over, over the magnet's."""
LEAST_DOUBT = 0.01
"""Least relative standard deviation of the spin's J: few stretches tell it."""
PULSE_TELLS = 2
"""Independent errors of a pulse, one of each axis: what is wrong with the lost voltage is alike."""
NUDGE = 1e-6
"""Angle for derivatives [rad]."""


@dataclass(frozen=True)
class Joint:
    """Result of the fit."""

    samples: Samples
    share: float
    """1 / J over that of the spin"""
    doubt: float
    """relative standard deviation of J"""


@dataclass(frozen=True)
class _Known:
    """What does not change during the fit."""

    model: Saturation
    psi_f: float
    turn: float
    """3/2 n_p^2 / J of the spin [rad/s^2 per V s A]"""
    i_rated: float

    def psi(self, i: Complex) -> Complex:
        """Flux linkage of the model less its magnet's, plus the magnet's that was measured."""
        at = flux(self.model, np.stack([np.r_[i, 0.0].real, np.r_[i, 0.0].imag], axis=-1))
        psi = at[:, 0] + 1j * at[:, 1]
        return np.asarray(psi[:-1] - psi[-1] + self.psi_f)


@dataclass
class _Pulse:
    """Linear equations of one pulse, real above imaginary parts."""

    group: int
    rows: slice
    use: NDArray[np.bool_]
    """(n,) which samples count"""
    i: Complex
    """in the rotor's frame, of samples that count"""
    back: Complex
    matrix: Floats
    wanted: Floats
    free: Floats
    """columns of a and b"""


def fit_jointly(
    groups: Sequence[Group],
    model: Saturation,
    psi_f: float,
    turn: float,
    doubt: float,
    i_rated: float,
) -> Joint:
    """Fit all groups; while one leaves too much over, without it.

    ``turn``: 3/2 n_p^2 / J of the spin; ``doubt``: relative standard deviation of that J.
    """
    known = _Known(model, psi_f, turn, i_rated)
    used = list(groups)
    while True:
        found, left = _solved(used, known, max(doubt, LEAST_DOUBT))
        worst = int(np.argmax(left))
        if left[worst] <= OUTLIER * np.median(left) or len(used) <= len(groups) // 2:
            return found
        del used[worst]


def _solved(groups: Sequence[Group], k: _Known, doubt: float) -> tuple[Joint, Floats]:
    """The fit, and what each group leaves over [Vs]."""
    psi = [closed(g, k.psi_f, np.zeros(len(g.i)))[0] for g in groups]
    share, noise = 1.0, NOISE * k.psi_f
    for _ in range(ROUNDS):
        pulses = [p for n, g in enumerate(groups) for p in _equations(n, g, psi[n], share, k)]
        bases = [np.linalg.qr(p.free)[0] for p in pulses]
        A, y = (
            np.concatenate([x - q @ (q.T @ x) for x, q in zip(parts, bases, strict=True)])
            for parts in ([p.matrix for p in pulses], [p.wanted for p in pulses])
        )
        alike = np.sqrt(len(y) / (PULSE_TELLS * len(pulses)))
        prior = np.r_[np.zeros(A.shape[1] - 1), noise * alike / doubt]
        A, y = np.r_[A, prior[None]], np.r_[y, prior[-1]]
        scale = np.linalg.norm(A, axis=0)
        x = np.linalg.lstsq(A / scale, y, rcond=None)[0] / scale
        noise = max(rms(y - A @ x), 1e-6 * k.psi_f)
        share = float(np.clip(x[-1], 0.5 * share, 2.0 * share))
        left = [0.0] * len(groups)
        for p in pulses:
            over = p.wanted - p.matrix @ x
            ab = np.linalg.lstsq(p.free, over, rcond=None)[0]
            left[p.group] = max(left[p.group], rms(over - p.free @ ab))
            psi[p.group][p.rows] = _path(groups[p.group], p.rows) - _line(p.rows, ab)
    spread = np.linalg.pinv((A / scale).T @ (A / scale))[-1, -1]
    std = float(noise * alike * np.sqrt(spread) / scale[-1] / share)
    i = np.concatenate([p.i for p in pulses])
    out = [psi[p.group][p.rows][p.use] * p.back - k.psi_f for p in pulses]
    turned = max(float(np.abs(np.angle(p.back)).max()) for p in pulses)
    return Joint(Samples(i, np.concatenate(out), noise / k.psi_f, turned), share, std), np.array(
        left
    )


def _equations(n: int, g: Group, psi: Complex, share: float, k: _Known) -> list[_Pulse]:
    speed = np.cumsum(k.turn * (psi.conj() * g.i).imag) * g.T_s
    full = np.r_[0.0, np.cumsum(speed[:-1]) * g.T_s]  # the angle at the spin's J
    back = np.exp(-1j * share * full)
    out = []
    for a, b in zip(g.bounds, g.bounds[1:], strict=False):
        rows = slice(a, b + 1)
        use = np.abs(g.i[rows]) <= COVERED * k.i_rated
        r, i = back[rows][use].conj(), (g.i * back)[rows][use]
        model = k.psi(i) * r
        nudged = k.psi(i * np.exp(-1j * NUDGE)) * r * np.exp(1j * NUDGE)
        by_share = (nudged - model) / NUDGE * full[rows][use]
        x = i / k.i_rated
        columns = np.c_[
            powers(x, POWERS_D) * r[:, None], 1j * powers(x, POWERS_Q) * r[:, None], by_share
        ]
        line = np.stack([_line(rows, e)[use] for e in np.eye(4)], axis=-1) * k.psi_f
        wanted = _path(g, rows)[use] - model + by_share * share
        out.append(
            _Pulse(n, rows, use, i, r.conj(), _real(columns), _real(wanted), _real(line) / k.psi_f)
        )
    return out


def _path(g: Group, rows: slice) -> Complex:
    return np.asarray(g.path[rows] - g.path[rows.start])


def _line(rows: slice, ab: Floats) -> Complex:
    """Value and drift of a pulse, each a complex number of two parts."""
    n = rows.stop - rows.start
    return np.asarray(ab[0] + 1j * ab[1] + (ab[2] + 1j * ab[3]) * np.linspace(-0.5, 0.5, n))


def _real(z: Complex) -> Floats:
    return np.concatenate([z.real, z.imag])

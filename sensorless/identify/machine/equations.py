"""Linear equations of one pulse for the fit over all of them, see ``joint.py``."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.identify.machine.curves import POWERS_D, POWERS_Q, powers
from sensorless.identify.machine.details import Details, flux_columns, torque_columns
from sensorless.identify.machine.electric import Complex, parts, plane
from sensorless.identify.machine.pulses import Group
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Saturation

COVERED = 1.3
"""Current over rated up to which samples count."""
ROUNDS = 3
"""Of the turn and the torque of harmonics from each other."""
NUDGE = 1e-6
"""Angle for derivatives [rad]."""


@dataclass(frozen=True)
class Known:
    """What does not change during the fit."""

    model: Saturation
    psi_f: float
    turn: float
    """3/2 n_p^2 / J of the spin [rad/s^2 per V s A]"""
    i_rated: float

    def psi(self, i: Complex) -> Complex:
        """Flux linkage of the model less its magnet's, plus the magnet's that was measured."""
        psi = plane(flux(self.model, parts(np.r_[i, 0.0])))
        return np.asarray(psi[:-1] - psi[-1] + self.psi_f)


@dataclass(frozen=True)
class State:
    """What a round finds besides the polynomial."""

    details: Details
    stood: Floats
    """angle at which the rotor stood at each place, from it, and of each group from there [rad]"""
    share: float
    """1 / J over that of the spin"""


@dataclass(frozen=True)
class Pulse:
    """Linear equations of one pulse, real above imaginary parts."""

    group: int
    rows: slice
    use: NDArray[np.bool_]
    """(n,) which samples count"""
    i: Complex
    """in the rotor's frame, of samples that count"""
    back: Complex
    """into the rotor's frame"""
    turned: float
    """most that the rotor turned [rad]"""
    details: Complex
    """(n, 4) columns of the details in the rotor's frame"""
    matrix: Floats
    """columns of the polynomial, the details, ``State.stood`` and ``State.share``"""
    wanted: Floats
    free: Floats
    """columns of a and b"""


def equations(
    n: int, g: Group, stands: Floats, psi: Complex, state: State, k: Known
) -> list[Pulse]:
    """Return those of group n.

    ``stands``: which of ``State.stood`` it has, each 1 or 0; ``psi``: its flux linkage [Vs].
    """
    stood = float(stands @ state.stood)
    off = g.place + stood - g.theta
    emf = np.r_[0.0, np.diff(g.path)] / g.T_s
    full, by_details, six = _turned(g, off, psi, emf, state, k)
    back = np.exp(-1j * (off + state.share * full))
    out = []
    for a, b in zip(g.bounds, g.bounds[1:], strict=False):
        rows = slice(a, b + 1)
        use = np.abs(g.i[rows]) <= COVERED * k.i_rated
        r, i = back[rows][use].conj(), (g.i * back)[rows][use]
        at = k.psi(i)
        nudged = k.psi(i * np.exp(-1j * NUDGE)) * np.exp(1j * NUDGE)
        by_angle = (nudged - at) / NUDGE * r
        by_share = by_angle * full[rows][use]
        turns = state.share * by_angle[:, None] * by_details[rows][use]
        x = i / k.i_rated
        details = flux_columns(k.model, at, k.psi_f, six[rows][use], (emf * back)[rows][use])
        polynomial = np.c_[powers(x, POWERS_D), 1j * powers(x, POWERS_Q)]
        matrix = np.c_[
            polynomial * r[:, None],
            details * r[:, None] + turns,
            by_angle[:, None] * stands,
            by_share,
        ]
        wanted = path(g, rows)[use] - at * r + by_angle * stood + by_share * state.share
        wanted = wanted + turns @ state.details.all
        out.append(
            Pulse(
                group=n,
                rows=rows,
                use=use,
                i=i,
                back=r.conj(),
                turned=float(np.abs(state.share * full[rows]).max()),
                details=details,
                matrix=_real(matrix),
                wanted=_real(wanted),
                free=_real(np.stack([line(rows, e)[use] for e in np.eye(4)], axis=-1)),
            )
        )
    return out


def _turned(
    g: Group, off: float, psi: Complex, emf: Complex, state: State, k: Known
) -> tuple[Floats, Floats, Complex]:
    """(n,) turn of the rotor at the spin's J [rad], (n, 4) what each detail adds to it per unit.

    Also (n,) exp(j 6 theta) of its angle theta in the stator.
    """
    full = np.zeros(len(g.i))
    alone = _twice((psi.conj() * g.i).imag, g, k)
    for _ in range(ROUNDS):
        back = np.exp(-1j * (off + state.share * full))
        six = np.asarray((np.exp(1j * g.theta) / back) ** 6)
        torques = torque_columns(g.i * back, psi * back, k.psi_f, six, emf * back)
        by_details = _twice(torques, g, k)
        full = alone + by_details @ state.details.all
    return full, by_details, six


def _twice(torque: Floats, g: Group, k: Known) -> Floats:
    """Turn [rad] by a torque over 3/2 n_p [Vs A], rows in time."""
    speed = np.cumsum(k.turn * torque, axis=0) * g.T_s
    return np.concatenate([np.zeros_like(speed[:1]), np.cumsum(speed[:-1], axis=0) * g.T_s])


def path(g: Group, rows: slice) -> Complex:
    """(n,) integral of the voltage since the start of a pulse [Vs]."""
    return np.asarray(g.path[rows] - g.path[rows.start])


def line(rows: slice, ab: Floats) -> Complex:
    """(n,) value and drift of a pulse, each a complex number of two parts."""
    n = rows.stop - rows.start
    return np.asarray(ab[0] + 1j * ab[1] + (ab[2] + 1j * ab[3]) * np.linspace(-0.5, 0.5, n))


def _real(z: Complex) -> Floats:
    return np.concatenate([z.real, z.imag])

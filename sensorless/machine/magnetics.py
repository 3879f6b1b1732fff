"""Design quantities of a machine's flux map: inverse map, inductances, cross-coupling, MTPA."""

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import FLUX_MAP, Array, lib
from sensorless.core.machine import flux_correction_currents, flux_map_currents
from sensorless.errors import UserError
from sensorless.machine.flux_correction import correction_key
from sensorless.machine.motor import Motor, Saturation

Floats = NDArray[np.float64]
Watts = TypeVar("Watts", float, Floats)


@lru_cache(maxsize=256)
def flux_map_record(s: Saturation) -> Array:
    """The C struct ``flux_map_t`` of a saturation model, shape (), read-only."""
    record = np.zeros((), dtype=FLUX_MAP)
    for name in (
        "a_d0",
        "a_dd",
        "a_q0",
        "a_qq",
        "i_f",
        "a_b",
        "a_bp",
        "k_q",
        "psi_n",
        "S",
        "T",
        "U",
        "V",
        "W",
    ):
        record[name] = getattr(s, name)
    record["c_d"] = s.a_dq / (s.V + 2)
    record["c_q"] = s.a_dq / (s.U + 2)
    record.flags.writeable = False
    return record


def extra_terms(s: Saturation) -> int:
    """What a saturation model has beyond saturation: a bridge or nothing, EXTRA_* of the core."""
    return int(lib.EXTRA_BRIDGE if s.a_b > 0.0 else lib.EXTRA_NONE)


def plant_map(motor: Motor) -> tuple[Array, int]:
    """``flux_map_t`` of the simulated machine, shape (), and what it has beyond saturation."""
    if motor.flux_correction is None:
        return flux_map_record(motor.saturation), extra_terms(motor.saturation)
    record = flux_map_record(motor.saturation).copy()
    record["correction"] = correction_key(motor.flux_correction)
    return record, int(lib.EXTRA_CORRECTION)


def plant_currents(motor: Motor, psi: Floats) -> Floats:
    """Currents (n, 2) [A] of the simulated machine at flux linkages (n, 2) [Vs]."""
    own = currents(motor.saturation, psi)
    if motor.flux_correction is None:
        return own
    return np.asarray(own + flux_correction_currents(motor.flux_correction.record, psi))


def currents(s: Saturation, psi: Floats) -> Floats:
    """Currents (n, 2) [A] at flux linkages (n, 2) [Vs]."""
    return flux_map_currents(flux_map_record(s), extra_terms(s), psi)


def cross_term(psi: Floats, U: int, V: int) -> tuple[Floats, Floats]:
    """i_d and i_q (n,) of the cross term of ``Saturation`` for a_dq = 1, at psi (n, 2)."""
    d, q = psi.T
    ad, aq = np.abs(d), np.abs(q)
    return ad**U * aq ** (V + 2) * d / (V + 2), ad ** (U + 2) * aq**V * q / (U + 2)


SIDES = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])[:, None]
"""Steps to both sides of a flux linkage, axis by axis."""


def inverse_inductance(s: Saturation, psi: Floats, step: float | None = None) -> Floats:
    """Jacobian d(i_d, i_q)/d(psi_d, psi_q) [1/H], shape (n, 2, 2), by central differences.

    ``step`` [Vs] is by default a millionth of 1 Vs, or of the magnet's flux if that is less.
    """
    if step is None:
        step = 1e-6 * min(1.0, s.i_f / s.a_d0 if s.i_f > 0.0 else 1.0)
    return slopes(lambda at: currents(s, at), psi, step)


def slopes(of: Callable[[Floats], Floats], psi: Floats, step: float) -> Floats:
    """Jacobian of currents over flux linkages, as ``inverse_inductance``."""
    around = (psi + step * SIDES).reshape(-1, 2)
    i = of(around).reshape(2, 2, -1, 2)
    return np.asarray((i[:, 0] - i[:, 1]).transpose(1, 2, 0) / (2.0 * step))


def flux(s: Saturation, i: Floats) -> Floats:
    """Flux linkages (n, 2) [Vs] at currents (n, 2) [A]: Newton's method on the map.

    Raises
    ------
    UserError
        The map has no flux linkage for a current.
    """
    target = np.atleast_2d(np.asarray(i, dtype=float))
    psi = np.stack(
        [(target[:, 0] + s.i_f) / (s.a_d0 + s.a_dd), target[:, 1] / (s.a_q0 + s.a_qq)], axis=-1
    )
    error = np.full_like(psi, np.inf)
    with suppress(np.linalg.LinAlgError), np.errstate(all="ignore"):
        for _ in range(100):
            error = currents(s, psi) - target
            if np.max(np.abs(error)) < 1e-11:
                return psi
            move = np.linalg.solve(inverse_inductance(s, psi), error[..., None])[..., 0]
            psi = psi - np.clip(move, -0.3, 0.3)
    if np.max(np.abs(error)) < 1e-8:
        return psi
    raise UserError(
        "saturation: the flux map has no inverse at some currents in use; check its "
        "coefficients, or lower i_max"
    )


def torque(motor: Motor, i: Floats) -> Floats:
    """Torque [N m] at currents (n, 2) [A]."""
    return torque_of(motor.n_p, flux(motor.saturation, i), i)


def torque_of(n_p: int, psi: Floats, i: Floats) -> Floats:
    """Torque [N m] of flux linkages (n, 2) [Vs] and currents (n, 2) [A]."""
    return np.asarray(1.5 * n_p * (psi[:, 0] * i[:, 1] - psi[:, 1] * i[:, 0]))


def mtpa(motor: Motor, n: int = 49) -> Floats:
    """Currents (n, 2) [A] of maximum torque per ampere, from zero to ``motor.i_max``."""
    return _mtpa(motor.saturation, motor.n_p, motor.i_max, n)


@lru_cache(maxsize=512)
def _mtpa(s: Saturation, n_p: int, i_max: float, n: int) -> Floats:
    """``mtpa`` by all that it depends on: machines that differ in the rest share it."""
    amplitude = np.linspace(0.0, i_max, n)
    angle = np.linspace(0.0, 0.5 * np.pi, 181)[:-1]
    grid = np.stack(
        [-np.outer(amplitude, np.sin(angle)), np.outer(amplitude, np.cos(angle))], axis=-1
    )
    points = grid.reshape(-1, 2)
    tau = torque_of(n_p, flux(s, points), points).reshape(n, -1)
    best = np.clip(np.argmax(tau, axis=1), 1, len(angle) - 2)
    rows = np.arange(n)
    left, mid, right = tau[rows, best - 1], tau[rows, best], tau[rows, best + 1]
    bend = left - 2.0 * mid + right
    shift = np.where(np.abs(bend) > 1e-12, 0.5 * (left - right) / np.where(bend == 0, 1, bend), 0)
    at = np.clip((best + np.clip(shift, -1.0, 1.0)) * (angle[1] - angle[0]), 0.0, None)
    line = np.stack([-amplitude * np.sin(at), amplitude * np.cos(at)], axis=-1)
    line.flags.writeable = False
    return line


def at_zero_current(s: Saturation, i_rated: float) -> tuple[float, float, float]:
    """Incremental L_d and L_q [H], and psi_f [Vs], at zero current, for a rated current [A]."""
    step = 1e-3 * i_rated
    psi = flux(s, np.array([[0.0, 0.0], [-step, 0.0], [step, 0.0], [0.0, -step], [0.0, step]]))
    d, q = psi[2, 0] - psi[1, 0], psi[4, 1] - psi[3, 1]
    return float(d) / (2.0 * step), float(q) / (2.0 * step), float(psi[0, 0])


def iron_conductance(motor: Motor, p_iron: Watts) -> Watts:
    """Conductance beside the windings [1/ohm] that loses p [W] at rated speed without load."""
    return p_iron / (1.5 * (motor.omega_rated * motor.psi_f) ** 2)


def apparent_q_inductance(motor: Motor, i: Floats) -> Floats:
    """psi_q / i_q [H] at currents (n, 2) with i_q > 0: with it the angle of the EMF is exact."""
    return np.asarray(flux(motor.saturation, i)[:, 1] / i[:, 1])


def cross_angle(motor: Motor, i: Floats) -> Floats:
    """Angle theta_cross [rad] by which current turns the magnetic axes, at currents (n, 2).

    The injection estimator locks at theta_e - theta_cross. Half of theta_m of doi
    10.12177/emca.2025.011, Eq. 16, whose m stands for magnetic.
    """
    gamma = inverse_inductance(motor.saturation, flux(motor.saturation, i))
    return np.asarray(0.5 * np.arctan2(-2.0 * gamma[:, 0, 1], gamma[:, 0, 0] - gamma[:, 1, 1]))

"""Random interior-magnet machines to train on: each consistent, none a shipped one.

A machine is drawn in per-unit values of its own rated current, speed and voltage, u_dc / sqrt(3),
from ``RANGES``. A machine that contradicts itself is drawn again, see ``_objection``.
"""

import hashlib
import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.design.control import operating_line, torque_constant
from sensorless.design.cross_coupling import working_current
from sensorless.envs.counter_random import Draws, check_seed, combine
from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats, cross_angle, flux, inverse_inductance, torque
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

NAME = "ipmsm-2"
"""Name of these ranges and checks; if they change, the name has to change."""

MOST_MACHINES = 256
"""Largest number of machines of a family."""


@dataclass(frozen=True)
class Range:
    """Bounds of one number, and the reason for them."""

    low: float
    high: float
    why: str
    log: bool = False
    """Uniform in the logarithm."""


RANGES = {
    "n_p": Range(2.0, 20.999, "whole part: four poles to a gearless hub's forty", log=True),
    "n_rated_rpm": Range(120.0, 6000.0, "gearless drives to spindles", log=True),
    "u_dc": Range(12.0, 660.0, "one lead battery to rectified 460 V mains", log=True),
    "i_rated": Range(3.0, 400.0, "peak, battery tools to traction", log=True),
    "emf": Range(0.35, 1.0, "no-load EMF at rated speed: reluctance-assisted to all magnet"),
    "x_d": Range(0.1, 0.45, "d reactance of machines with buried magnets"),
    "saliency": Range(1.36, 6.6, "L_q / L_d of published salient machines", log=True),
    "r": Range(0.01, 0.1, "resistance: traction machine to a small one of 12 V", log=True),
    "sat_q": Range(0.0, 0.5, "share that the iron of q adds to 1 / L_q at rated current"),
    "sat_d": Range(0.0, 0.3, "share of the iron in 1 / L_d at no load"),
    "cross": Range(0.0, 0.45, "share of cross-saturation in 1 / L_q: up to 15 degrees at rated"),
    "linear": Range(0.0, 1.0, "share that stands for ``LINEAR``"),
    "exponent": Range(1.0, 4.0, "whole part: how suddenly q saturates"),
    "loading": Range(0.75, 1.0, "current that rated torque needs: name plates round up"),
    "start_time": Range(0.03, 0.45, "J omega / tau, rated [s]: bare servo shaft to fan", log=True),
    "friction": Range(0.005, 0.03, "of rated torque at rated speed"),
    "i_max": Range(1.2, 1.5, "overload of a drive without derating"),
    "carrier": Range(0.009, 0.03, "injected q current a radian of error over rated", log=True),
    "T_s": Range(5e-5, 2e-4, "PWM of 5 to 20 kHz [s]", log=True),
    "dead_time": Range(0.002, 0.015, "over T_s: MOSFETs at 10 kHz to IGBTs", log=True),
}
MOST_TORQUE, LEAST_TORQUE = 1260.0, 0.4
"""Rated torques [N m]; injection and control need ``PERIODS`` an electrical turn at rated speed."""
PERIODS = 20.0
LINEAR = 0.3
"""Share of machines without saturation."""


def family(seed: int, n: int) -> tuple[Motor, ...]:
    """Draw n machines; machine i is a function of the seed and i alone.

    Raises
    ------
    UserError
        A seed below 0 or beyond 2^63, no machine, or more than ``MOST_MACHINES``.
    """
    check_seed(seed)
    if not 1 <= n <= MOST_MACHINES:
        raise UserError(f"machines: {n}: must be between 1 and {MOST_MACHINES}")
    return tuple(member(seed, i) for i in range(n))


def family_digest(motors: tuple[Motor, ...]) -> str:
    """SHA-256 over the digests of machines, hexadecimal."""
    return hashlib.sha256("".join(motor.digest for motor in motors).encode()).hexdigest()


@lru_cache(maxsize=MOST_MACHINES)
def member(seed: int, i: int) -> Motor:
    """Draw machine i alone."""
    for attempt in range(1000):
        motor = _drawn(f"{NAME}:{seed}:{i}", Draws(combine(seed, i, attempt)))
        if motor is not None and _objection(motor) is None:
            return motor
    raise AssertionError("the ranges hold no consistent machine")


def _drawn(name: str, d: Draws) -> Motor | None:
    """One machine, or none if rated torque has no operating point on its flux map."""
    x = {key: _number(d, limits) for key, limits in RANGES.items()}
    n_p, i_rated = int(x["n_p"]), x["i_rated"]
    omega = n_p * x["n_rated_rpm"] * RPM_TO_RAD_S
    base, T_s = x["u_dc"] / math.sqrt(3.0) / omega, x["T_s"]
    if 2.0 * math.pi / (omega * T_s) < PERIODS:
        return None
    if x["linear"] < LINEAR:
        x |= {"sat_q": 0.0, "sat_d": 0.0, "cross": 0.0}
    psi_f, L_d = _rounded(x["emf"] * base), _rounded(x["x_d"] * base / i_rated)
    L_q = _rounded(L_d * x["saliency"])
    tables: dict[str, Any] = {
        "name": name,
        "description": "random machine of the family " + NAME,
        "machine": {"n_p": n_p, "R_s": _rounded(x["r"] * base * omega / i_rated),
                    "L_d": L_d, "L_q": L_q, "psi_f": psi_f, "J": 1.0, "B": 0.0},
        "rating": {"tau_rated": 1.0, "i_rated": i_rated, "n_rated_rpm": x["n_rated_rpm"],
                   "u_dc": x["u_dc"]},
        "saturation": _saturation(x, L_d, L_q, psi_f, i_rated),
        "drive": {
            "T_s": T_s,
            "u_inj": _rounded(2.0 * x["carrier"] * i_rated / (T_s * (1.0 / L_d - 1.0 / L_q))),
            "i_max": _rounded(x["i_max"] * i_rated),
            "i_trip": _rounded(3.0 * i_rated),
            "dead_time": _rounded(x["dead_time"] * T_s),
            "adc_range": _rounded(2.0 * i_rated),
            "adc_bits": 12,
        },
    }  # fmt: skip
    try:
        line, tau = _line(Motor.from_tables(tables, name))
    except UserError:  # a flux map without an inverse
        return None
    rated = float(np.interp(x["loading"] * i_rated, np.hypot(*line.T), tau))
    if not LEAST_TORQUE <= rated <= MOST_TORQUE:
        return None
    speed = x["n_rated_rpm"] * RPM_TO_RAD_S
    tables["rating"]["tau_rated"] = _rounded(rated)
    tables["machine"]["J"] = _rounded(x["start_time"] * rated / speed)
    tables["machine"]["B"] = _rounded(x["friction"] * rated / speed)
    return Motor.from_tables(tables, name)


def _number(d: Draws, r: Range) -> float:
    """Draw one number, rounded as on a datasheet."""
    if r.log:
        return _rounded(float(np.exp(d.uniform(math.log(r.low), math.log(r.high)))[0]))
    return _rounded(float(d.uniform(r.low, r.high)[0]))


def _rounded(x: float) -> float:
    return float(f"{x:.4g}")


def _saturation(
    x: dict[str, float], L_d: float, L_q: float, psi_f: float, i_rated: float
) -> dict[str, float]:
    """Coefficients of the flux map with these inductances [H] and this flux [Vs] at no current."""
    S, T = 4, int(x["exponent"])
    a_dd = x["sat_d"] / (L_d * (S + 1) * psi_f**S)
    a_d0 = (1.0 - x["sat_d"]) / L_d
    return {
        "a_d0": a_d0,
        "a_dd": a_dd,
        "S": S,
        "i_f": (a_d0 + a_dd * psi_f**S) * psi_f,
        "a_q0": (1.0 - x["cross"]) / L_q,
        "a_qq": x["sat_q"] / (L_q * (L_q * i_rated) ** T),
        "T": T,
        "a_dq": 2.0 * x["cross"] / (L_q * psi_f**2),
    }


def _line(motor: Motor) -> tuple[Floats, Floats]:
    """Currents (n, 2) [A] of maximum torque per ampere, and their torque (n,) [N m]."""
    line = operating_line(motor, True)
    return line, torque(motor, line)


def _objection(motor: Motor) -> str | None:
    """Say what is wrong with a machine, by the limits of machines that drives are sold for."""
    if motor.u_inj > motor.u_dc / 5.0:
        return "injection takes more than a fifth of the DC link"
    line, tau = _line(motor)
    inside = line[np.hypot(*line.T) <= motor.i_max]
    low, high = np.linalg.eigvalsh(
        inverse_inductance(motor.saturation, flux(motor.saturation, inside))
    ).T
    if np.any(low / high > 0.75):
        return "saliency lost within the current limit"
    i_q = working_current(motor, line, 1.0)
    rated = np.array([[np.interp(i_q, line[:, 1], line[:, 0]), i_q]])
    if abs(cross_angle(motor, rated)[0]) > math.radians(15.0):
        return "cross-coupling beyond 15 degrees"
    psi, w, R_s = flux(motor.saturation, rated)[0], motor.omega_rated, motor.R_s
    u = math.hypot(R_s * rated[0, 0] - w * psi[1], R_s * rated[0, 1] + w * psi[0])
    if u > 1.15 * motor.u_dc / math.sqrt(3.0):
        return "rated torque at rated speed needs deep field weakening"
    slope = np.diff(tau) / np.diff(line[:, 1])
    if motor.n_p * np.max(slope[line[:-1, 1] < i_q]) > 2.0 * torque_constant(motor):
        return "torque rises too steeply for one speed loop"
    return None

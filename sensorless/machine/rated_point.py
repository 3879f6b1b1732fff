"""How much of its name plate a machine reaches within its current and its voltage."""

import math
from dataclasses import dataclass

import numpy as np

from sensorless.machine.magnetics import Floats, flux, mtpa, torque, torque_of
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

USABLE = 0.97
"""Share of u_dc / sqrt(3) that field weakening lets the control use, ``fw_margin``."""
ROUNDING = 0.02
"""Share by which a machine may miss its name plate, whose numbers are rounded."""
SPARE = 1.5
"""Torque of rated current over rated torque, beyond which the two are hardly of one machine: peak
for RMS makes 1.4 of it, line for phase voltage 1.7."""

SHORT = 1.2
"""Rated torque over that of rated current, above which a mix-up is likelier than rounding."""
MIXED = " (peak values? RMS current makes 0.71 of it, the voltage of a phase 0.58)"
"""Asked then: rated torque over current is 1.41 or 1.73 times what the two would make."""


@dataclass(frozen=True)
class RatedPoint:
    """Torque and speed that rated current and the DC link allow."""

    torque: float
    """largest torque at rated current, low speed [N m]"""
    current: float
    """least current of rated torque at low speed [A], infinite if i_max does not give it"""
    torque_at_speed: float
    """largest torque at rated speed within rated current and voltage [N m]"""
    speed: float
    """largest speed of rated torque within rated current and voltage, at most rated [r/min]"""
    base_speed: float
    """speed up to which the least current of rated torque needs no field weakening [r/min], or that
    of the most torque of i_max if that is just short of it"""
    top_speed: float
    """largest speed without load and without field weakening [r/min]"""

    def objection(self, motor: Motor) -> str | None:
        """Why the rated point is out of reach, and what is reached; None if it is reached."""
        few = 1.0 - ROUNDING
        found = []
        if self.torque < few * motor.tau_rated:
            found.append(
                f"rated torque {motor.tau_rated:g} N m needs "
                + (f"{self.current:.3g} A" if math.isfinite(self.current) else "more than i_max")
                + f", but i_rated is {motor.i_rated:g} A, which gives {self.torque:.3g} N m"
                + (MIXED if motor.tau_rated > SHORT * self.torque else "")
            )
        if self.torque_at_speed < few * min(motor.tau_rated, self.torque):
            reached = f"up to {self.speed:.0f} r/min" if self.speed > 0.0 else "nowhere"
            found.append(
                f"{motor.tau_rated:g} N m at {motor.n_rated_rpm:g} r/min is beyond "
                f"{motor.u_dc:g} V: rated torque is reached {reached}, and "
                f"rated speed with {self.torque_at_speed:.3g} N m"
            )
        return "; ".join(found) or None

    def spare(self, motor: Motor) -> str | None:
        """What is odd about a rated torque far below that of rated current; None if it is not."""
        if self.torque <= SPARE * motor.tau_rated:
            return None
        return (
            f"i_rated = {motor.i_rated:g} A gives {self.torque:.3g} N m, "
            f"{self.torque / motor.tau_rated:.2g} times tau_rated: is a current, a voltage or the "
            "number of pole pairs in another unit?"
        )


def rated_point(motor: Motor) -> RatedPoint:
    """Search all currents within the limits on a grid of amplitudes and angles.

    The least current of rated torque is on the curve of maximum torque per ampere.
    """
    i = polar(motor)
    psi = flux(motor.saturation, i)
    tau = torque_of(motor.n_p, psi, i)
    size = np.hypot(*i.T)
    rated = size <= (1.0 + 1e-9) * motor.i_rated
    enough = tau >= (1.0 - ROUNDING) * motor.tau_rated
    top = top_speeds(motor, i, psi)
    reaches = rated & (top >= motor.omega_rated)
    current, base = _least_current(motor)
    to_rpm = 1.0 / (motor.n_p * RPM_TO_RAD_S)
    within = top[rated & enough]
    return RatedPoint(
        torque=float(tau[rated].max(initial=0.0)),
        current=current,
        torque_at_speed=float(tau[reaches].max(initial=0.0)),
        speed=min(float(within.max(initial=0.0)) * to_rpm, motor.n_rated_rpm),
        base_speed=base * to_rpm,
        top_speed=float(top[0]) * to_rpm,
    )


def _least_current(motor: Motor) -> tuple[float, float]:
    """Least current of rated torque [A], and the largest electrical speed with it [rad/s].

    Where ``i_max`` falls short, the current is infinite, and the speed that of the most torque, or
    zero if that is short by more than ``ROUNDING``.
    """
    i = mtpa(motor)
    tau = torque(motor, i)
    wanted = min(motor.tau_rated, float(tau.max()))
    if wanted < (1.0 - ROUNDING) * motor.tau_rated:
        return math.inf, 0.0
    above = max(int(np.argmax(tau >= wanted)), 1)
    share = (wanted - tau[above - 1]) / (tau[above] - tau[above - 1])
    at = i[above - 1 : above] + share * (i[above] - i[above - 1])
    (top,) = top_speeds(motor, at, flux(motor.saturation, at))
    least = float(np.hypot(*at[0])) if wanted == motor.tau_rated else math.inf
    return least, float(top)


def polar(motor: Motor) -> Floats:
    """Currents (n, 2) [A] of a quarter plane: i_d <= 0, i_q >= 0; the first is zero.

    Rated current is one of the amplitudes.
    """
    size = np.linspace(0.0, motor.i_rated, 61)
    if motor.i_max > motor.i_rated:
        size = np.append(size, np.linspace(motor.i_rated, motor.i_max, 13)[1:])
    angle = np.linspace(0.0, 0.5 * np.pi, 91)
    i_d, i_q = -np.outer(size, np.sin(angle)), np.outer(size, np.cos(angle))
    return np.stack([i_d, i_q], axis=-1).reshape(-1, 2)


def top_speeds(motor: Motor, i: Floats, psi: Floats) -> Floats:
    """Largest electrical speed [rad/s] of each current within the voltage; zero if there is none.

    It is infinite without flux. |R_s i + j w psi| = u: a quadratic equation in w.
    """
    u = USABLE * motor.u_dc / math.sqrt(3.0)
    a = np.sum(psi**2, axis=1)
    b = motor.R_s * (psi[:, 0] * i[:, 1] - psi[:, 1] * i[:, 0])
    c = motor.R_s**2 * np.sum(i**2, axis=1) - u**2
    with np.errstate(divide="ignore", invalid="ignore"):
        w = (-b + np.sqrt(b**2 - a * c)) / a
    w = np.where(a > 0.0, w, np.inf)  # without flux, no voltage
    return np.where(c < 0.0, w, 0.0)

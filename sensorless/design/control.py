"""Speed and current control: from the machine and bandwidths to ``control_params_t``."""

import math
from typing import Any

import numpy as np

from sensorless.core.api import CURVE_N
from sensorless.design.cross_coupling import cross_curve, working_current
from sensorless.machine.magnetics import (
    Floats,
    apparent_q_inductance,
    flux,
    inverse_inductance,
    mtpa,
)
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import USABLE

BY_REFERENCE, RAMP = 0.18, 0.04
"""Angle by which the rotor turns in a PWM period at rated speed, times ``stiffening``, from which
the axes are decoupled by the current's reference [rad], and the ramp to all of it."""


def operating_line(motor: Motor, use_mtpa: bool) -> Floats:
    """Currents (CURVE_N, 2) [A] the drive works on, at evenly spaced i_q from 0 to ``i_max``.

    The first i_q is slightly above zero, so that quotients by i_q exist.
    """
    i_q = np.linspace(0.0, motor.i_max, CURVE_N)
    i_q[0] = 1e-4 * motor.i_max
    if not use_mtpa:
        return np.stack([np.zeros(CURVE_N), i_q], axis=-1)
    best_d, best_q = mtpa(motor).T
    return np.stack([np.interp(i_q, best_q, best_d), i_q], axis=-1)


def design_curves(
    motor: Motor, line: Floats, *, L_q_table: bool, cross: str, cross_torque: float = 0.5
) -> tuple[Floats, Floats, Floats]:
    """Curves over |i_q|: i_d of the operating line [A], L_q of the observer [H], theta_cross [rad].

    Parameters
    ----------
    L_q_table : bool
        Apparent inductance along the line, or the constant data-sheet value.
    cross, cross_torque : str, float
        As in ``cross_curve``.
    """
    L_q = apparent_q_inductance(motor, line) if L_q_table else np.full(CURVE_N, motor.L_q)
    angle = cross_curve(motor, line, cross, cross_torque)
    i_d = line[:, 0].copy()
    i_d[0] = 0.0
    return i_d, L_q, angle


def torque_constant(motor: Motor) -> float:
    """Torque constant of the speed loop, times pole pairs: k_t of ``design_control`` [N m/A].

    1.5 n_p^2 psi_f, the magnet's part, if the magnet alone makes rated torque from rated current;
    otherwise rated torque over its i_q at maximum torque per ampere. With the magnet's part alone,
    the speed loop of a reluctance machine would be much faster under load than its setting says.
    """
    magnet = 1.5 * motor.n_p**2 * motor.psi_f
    if magnet * motor.i_rated >= motor.n_p * motor.tau_rated:
        return magnet
    return motor.n_p * motor.tau_rated / working_current(motor, operating_line(motor, True), 1.0)


def half_load_inductance(motor: Motor) -> float:
    """Apparent q inductance at half the rated current [H], for which the control is designed."""
    return float(apparent_q_inductance(motor, np.array([[0.0, 0.5 * motor.i_rated]]))[0])


def stiffening(motor: Motor) -> float:
    """Largest ratio of an inductance of the control to the iron's up to ``i_max``, at least 1."""
    line = mtpa(motor)
    gamma = inverse_inductance(motor.saturation, flux(motor.saturation, line))
    d = float(np.max(motor.L_d * gamma[:, 0, 0]))
    q = float(np.max(half_load_inductance(motor) * gamma[:, 1, 1]))
    return max(1.0, d, q)


def reference_share(motor: Motor) -> float:
    """Share of the decoupling that is by the current's reference, 0 to 1; docs/control.md.

    The measured current is two periods old when the voltage acts. Where the rotor turns far in
    them, or the iron is stiffer than the control takes it, the loop swings against the rotor.
    """
    turn = stiffening(motor) * motor.omega_rated * motor.T_s
    return min(max((turn - BY_REFERENCE) / RAMP, 0.0), 1.0)


DEMAGNETISING = 0.9
"""Largest d current of field weakening, over ``i_max``: what it leaves makes torque."""
COMPENSATED = 0.05
"""Phase current from which all of a dead time is compensated, over rated: beyond the range in which
it turns round within a period."""


BRAKING = 0.1
"""Least torque current of a braking generator, over ``i_max``. It takes a percent of the voltage on
machines with little resistance, and brakes what an angle error or a load of some percent drives."""


def braking_current(motor: Motor, i_d: float) -> float:
    """Torque current that a generator keeps where it is short of voltage [A].

    With the auxiliary flux psi_a at the d current ``i_d`` and i_q against the speed, the voltage
    |u|^2 = (R i_d + w L_q |i_q|)^2 + (w psi_d - R |i_q|)^2 is least at
    |i_q| = R w psi_a / (R^2 + w^2 L_q^2), psi_a = psi_f + (L_d - L_q) i_d, here at rated speed;
    with this current at twice rated speed it is about what it is without torque. At least
    ``BRAKING``: without any, a drive that comes from beyond its voltage limit stays there.
    """
    w, L_q = motor.omega_rated, half_load_inductance(motor)
    psi_a = motor.psi_f + (motor.L_d - L_q) * i_d
    least = motor.R_s * w * psi_a / (motor.R_s**2 + (w * L_q) ** 2)
    return max(least, BRAKING * motor.i_max)


def weakening(speed_hz: float, current_hz: float) -> float:
    """Bandwidth of field weakening at rated speed [rad/s].

    Five times that of the speed loop, which asks for torque, at most a fifth of the current loop's.
    """
    return 2.0 * math.pi * min(5.0 * speed_hz, 0.2 * current_hz)


def design_control(
    motor: Motor,
    *,
    speed_hz: float,
    speed_weight: float,
    current_hz: float,
    i_q_slew: float,
    u_dt: float,
    omega_max: float,
) -> dict[str, Any]:
    """Fields of ``control_params_t`` except its curve ``i_d_mtpa``.

    Speed: critically damped closed loop of natural frequency ``speed_hz`` [Hz] on the inertia,
    k_p = 2 w J / k_t, k_i = w^2 J / k_t with k_t of ``torque_constant``. Current: internal-model
    control of bandwidth ``current_hz`` [Hz] (doi 10.1109/28.663477) with the q inductance at half
    the rated current. Field weakening: at rated speed its integrator, du/di_d = w L_d, has the
    bandwidth ``weakening``.

    Each period moves the speed integrator towards i_q plus the part of the reference that the
    proportional part leaves out, so it stays within ``i_int_max``, the largest of these; with a
    hundredth of that part more, for rounding. It counts torque currents as without weakening, and
    those are smaller by up to psi_f over the auxiliary flux at the most d current.

    Parameters
    ----------
    speed_weight : float
        Share of the speed reference in the proportional part, 0 (IP) to 1 (PI).
    i_q_slew : float
        Largest slope of the torque-current reference [A/s].
    u_dt : float
        Dead-time voltage to compensate [V], 0 for none.
    omega_max : float
        Bound of the speed estimate, electrical [rad/s].
    """
    w = 2.0 * math.pi * speed_hz
    k_t = torque_constant(motor)
    alpha = 2.0 * math.pi * current_hz
    L_q = half_load_inductance(motor)
    k_p = 2.0 * w * motor.J / k_t
    i_d_min = -DEMAGNETISING * motor.i_max
    least = motor.psi_f / (motor.psi_f + min(motor.L_d - L_q, 0.0) * i_d_min)
    return {
        "k_p_speed": k_p,
        "k_i_speed": w * w * motor.J / k_t,
        "weight_ref": speed_weight,
        "i_q_step": i_q_slew * motor.T_s,
        "i_max": motor.i_max,
        "k_t_d": alpha * motor.L_d,
        "k_t_q": alpha * L_q,
        "k_p_d": 2.0 * alpha * motor.L_d - motor.R_s,
        "k_p_q": 2.0 * alpha * L_q - motor.R_s,
        "k_i_d": alpha * alpha * motor.L_d * motor.T_s,
        "k_i_q": alpha * alpha * L_q * motor.T_s,
        "L_d": motor.L_d,
        "L_q": L_q,
        "psi_f": motor.psi_f,
        "by_reference": reference_share(motor),
        "k_fw": weakening(speed_hz, current_hz) * motor.T_s / (motor.omega_rated * motor.L_d),
        "fw_margin": USABLE,
        "i_d_min": i_d_min,
        "i_q_brake": braking_current(motor, i_d_min),
        "i_int_max": motor.i_max / least + k_p * (1.01 - speed_weight) * omega_max,
        "u_dt": u_dt,
        "inv_i_dt": 1.0 / (COMPENSATED * motor.i_rated),
        "curve_inv_step": (CURVE_N - 1) / motor.i_max,
    }

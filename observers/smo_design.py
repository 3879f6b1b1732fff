"""Sliding-mode observer: from the machine and bandwidths to ``smo_params_t``."""

import math
from typing import Any

from sensorless.core.api import enumeration
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.observers.pll_design import pll_gains

SWITCHING = enumeration("SMO_")


def deadbeat_gain(motor: Motor) -> float:
    """L_d / T_s [V/A]: the gain at which forward Euler removes the current error in one step.

    The observer is stable below twice this gain.
    """
    return motor.L_d / motor.T_s


def design_smo(
    motor: Motor,
    *,
    pll_hz: float,
    gain: float,
    k: float,
    cross_hz: float,
    emf_hz: float,
    floor_rpm: float,
    switching: str,
    lag_cure: bool,
    motoring: float,
    omega_max: float,
) -> dict[str, Any]:
    """Fields of ``smo_params_t``.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the PLL [Hz].
    gain : float
        Slope of the correction at zero error, g = k a / 2 [V/A]
        (doi 10.12177/emca.2025.011, Eq. 24).
    k : float
        Bound on the correction voltage [V]; must exceed the EMF at rated speed.
    cross_hz : float
        Low-pass on the speed in the model's cross term [Hz]; ``inf`` for none.
    emf_hz : float
        Low-pass on the EMF [Hz]; ``inf`` for none.
    floor_rpm : float
        Speed below which the EMF is not used [r/min].
    switching : str
        What corrects the model current, one of ``SWITCHING``.
    lag_cure : bool
        EMF from the exact steady-state relation.
    motoring : float
        Observer's q inductance as a motor over that as a generator; below 1 counts as 1.
    omega_max : float
        Bound on the speed estimate, electrical [rad/s].

    Raises
    ------
    UserError
        The gain is outside the stable range of the forward-Euler step.
    """
    if not 0.0 < gain < 2.0 * deadbeat_gain(motor):
        raise UserError(
            f"smo_gain: {gain:g} V/A; give more than 0 and less than 2 L_d/T_s = "
            f"{2.0 * deadbeat_gain(motor):g} V/A (stability of the forward-Euler step)"
        )
    k_p, k_i = pll_gains(pll_hz, 1.0)
    omega_floor = motor.rpm_to_electrical(floor_rpm)
    root, climb = super_twisting(motor, k)
    return {
        "pll": {"k_p": k_p, "k_i": k_i, "omega_max": omega_max},
        "R_s": motor.R_s,
        "L_d": motor.L_d,
        "k": k,
        "half_a": gain / k,
        "i_reach": 5.0 * k / gain,
        "switching": SWITCHING[switching],
        "root": root,
        "climb": climb * motor.T_s,
        "lag_cure": float(lag_cure),
        "L_q_rise": max(0.0, motoring - 1.0),
        "alpha_omega": low_pass(cross_hz, motor.T_s),
        "alpha_e": low_pass(emf_hz, motor.T_s),
        "e_floor": max(1.0, 0.5 * omega_floor * motor.psi_f),
        "omega_floor": omega_floor,
    }


def super_twisting(motor: Motor, k: float) -> tuple[float, float]:
    """Gains of the super-twisting correction over speed and over its square.

    z = k_1 |x|^½ sign(x) + v, dv/dt = k_2 sign(x) brings the current error x and its derivative to
    zero while |d²x/dt²| without z is at most C, for k_1 = 1.5 L_d C^½ and k_2 = 1.1 L_d C
    (doi 10.1080/0020717031000099029). That bound is the EMF's: of magnitude ω ψ and turning with
    the rotor, it changes by ω² ψ = L_d C at most. ψ is the flux whose EMF at rated speed is ``k``.

    Parameters
    ----------
    k : float
        Bound on the EMF at rated speed [V].

    Returns
    -------
    tuple of float
        k_1 / ω [V s/A^½] and k_2 / ω² [V s].
    """
    psi = k / motor.omega_rated
    return 1.5 * math.sqrt(motor.L_d * psi), 1.1 * psi


def low_pass(hertz: float, T_s: float) -> float:
    """Coefficient of a first-order low-pass sampled every ``T_s`` [s]; 1 for no filter."""
    return 1.0 if math.isinf(hertz) else -math.expm1(-2.0 * math.pi * hertz * T_s)

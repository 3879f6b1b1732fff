"""Flux observer: from the machine and bandwidths to ``flux_params_t``."""

import math
from typing import Any

from sensorless.machine.motor import Motor
from sensorless.observers.pll_design import pll_gains
from sensorless.observers.tracking import voltage_drift

APART = math.radians(5.0)
"""Angle at which injection, at full weight, holds a flux that the whole voltage of the dead time
turns [rad]. An inverter with half again that dead time, of which the drive compensates half, then
leaves 15 degrees at a quarter of the weight."""
STANDSTILL_SHARE = 0.1
"""Largest part of the correction that does not rise with speed, over rated electrical speed. The
correction has twice this rate. At the hand-over, a fifth of rated speed, it may be as fast as the
flux turns: with rate g, a voltage error of share v of the EMF turns the angle by delta with
sin(delta) = g / omega (1 - cos(delta) + v) + v, which has no solution for large g / omega."""
LEAST_SHARE = 0.03
"""The least, over rated electrical speed. Where resistance is that small, its bound leaves errors
of sensors and L_q next to undamped at low speed, and held braking loses the rotor:
docs/coupled-gains.md."""


def standstill_rate(motor: Motor) -> float:
    """Half the rate of the flux correction at standstill [1/s].

    b = R_s (L_d + L_q) / (2 L_d L_q), the bound of doi 10.1109/TIA.2018.2858753, from
    ``LEAST_SHARE`` to ``STANDSTILL_SHARE``.
    """
    b = 0.5 * motor.R_s * (motor.L_d + motor.L_q) / (motor.L_d * motor.L_q)
    return max(LEAST_SHARE, min(b / motor.omega_rated, STANDSTILL_SHARE)) * motor.omega_rated


def design_flux(
    motor: Motor, *, pll_hz: float, gain: float, floor_rpm: float, omega_max: float
) -> dict[str, Any]:
    """Fields of ``flux_params_t`` (doi 10.1109/TIA.2018.2858753).

    The flux is corrected along the auxiliary flux with ``standstill_rate`` + ``gain`` times the
    speed. Injection moves it across the auxiliary flux, at k times that flux a second for a radian
    of lead and full weight. Dead time that nothing compensates turns it by ``voltage_drift``;
    k = voltage_drift / ``APART`` stops it there.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the critically damped speed estimation [Hz].
    gain : float
        Rise of the correction with speed [-]; damping of the flux error.
    floor_rpm : float
        Speed below which the flux is not used [r/min].
    omega_max : float
        Bound on the speed estimate, electrical [rad/s].
    """
    k_p, k_i = pll_gains(pll_hz, 1.0, zeta=1.0)
    return {
        "pll": {"k_p": k_p, "k_i": k_i, "omega_max": omega_max},
        "gain_0": standstill_rate(motor) * motor.T_s,
        "gain_w": gain * motor.T_s,
        "k_turn": voltage_drift(motor) / APART * motor.T_s,
        "omega_floor": motor.rpm_to_electrical(floor_rpm),
    }

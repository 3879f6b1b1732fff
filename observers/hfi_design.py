"""Injection estimator: from the machine and bandwidths to ``hfi_params_t``."""

from typing import Any

from sensorless.motor import Motor
from sensorless.observers.pll_design import pll_gains


def hf_current(motor: Motor) -> float:
    """Amplitude of the injected current at no load [A], u_inj T_s / (2 L_d).

    Eq. 2 of doi 10.12177/emca.2025.011.
    """
    return motor.u_inj * motor.T_s / (2.0 * motor.L_d)


def error_slope(L_d: float, L_q: float) -> float:
    """Slope of the normalised error signal at lock [1/rad], 1 - L_d / L_q.

    From incremental inductances [H]; Eq. 7 with its exact denominator.
    """
    return 1.0 - L_d / L_q


def design_hfi(motor: Motor, pll_hz: float, hold: float, omega_max: float) -> dict[str, Any]:
    """Fields of ``hfi_params_t``.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the PLL [Hz].
    hold : float
        Time the injection stays on after the weight reached zero [s].
    omega_max : float
        Bound on the speed estimate, electrical [rad/s].
    """
    k_p, k_i = pll_gains(pll_hz, error_slope(motor.L_d, motor.L_q))
    return {
        "pll": {"k_p": k_p, "k_i": k_i, "omega_max": omega_max},
        "u_inj": motor.u_inj,
        "i_floor": 0.25 * hf_current(motor),
        "n_hold": max(1.0, round(hold / motor.T_s)),
    }

"""Injection estimator: from the machine and bandwidths to ``hfi_params_t``."""

import math
from typing import Any

from sensorless.core.api import enumeration
from sensorless.machine.motor import Motor
from sensorless.observers.pll_design import pll_gains
from sensorless.observers.smo_design import low_pass

SCHEMES = enumeration("HFI_")
RISE = (3.0 / 4.0, 3.0 / 2.0)
"""Errors, over the lag that an acceleration by rated torque leaves, at which the bandwidth of the
PLL starts to rise and at which it has risen by ``RISE_MAX``."""
RISE_MAX = 1.0
RISE_OVER = 4.0
"""Low-pass of the error that makes the bandwidth rise, over the PLL's natural frequency: it takes
most of the noise away, and a load comes within a period of the PLL."""
LAG_MOST = 1.0 / 3.0
"""Largest lag that counts [rad]: a third of what loses the drive."""


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


def error_signal(L_d: float, L_q: float, delta: float) -> float:
    """Normalised error signal [1] at an angle error ``delta`` [rad]; ``error_slope`` is its slope.

    From incremental inductances [H]: (L_q - L_d) s c / sqrt(L_q^2 c^2 + L_d^2 s^2), the q part of
    the injected current over all of it.
    """
    s, c = math.sin(delta), math.cos(delta)
    return (L_q - L_d) * s * c / math.hypot(L_q * c, L_d * s)


def design_hfi(
    motor: Motor,
    *,
    pll_hz: float,
    natural_hz: float,
    lag: float,
    hold: float,
    omega_max: float,
    scheme: str,
    delay_cure: bool,
    normalised: bool,
) -> dict[str, Any]:
    """Fields of ``hfi_params_t``.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the PLL [Hz].
    natural_hz : float
        What it is by the machine's formula [Hz].
    lag : float
        How far an acceleration by rated torque leaves a PLL of ``natural_hz`` behind [rad]. A PLL
        that is farther behind gets faster.
    hold : float
        Time that the injection stays on after the weight has reached zero [s].
    omega_max : float
        Bound on the speed estimate, electrical [rad/s].
    scheme : str
        One of ``SCHEMES``.
    delay_cure : bool
        Inject along the axis where it will be when the voltage acts, instead of where it was when
        the voltage was computed.
    normalised : bool
        Divide the error signal by the magnitude of the current's response (Eq. 7); otherwise by a
        constant that the response never reaches (Eq. 15), with which the gains fit at no load only
        and the bandwidth does not rise.
    """
    floor = (0.25 if normalised else 10.0) * hf_current(motor)
    slope = error_slope(motor.L_d, motor.L_q)
    low, high = (error_signal(motor.L_d, motor.L_q, x * min(lag, LAG_MOST)) for x in RISE)
    k_p, k_i = pll_gains(pll_hz, slope if normalised else slope * hf_current(motor) / floor)
    return {
        "pll": {"k_p": k_p, "k_i": k_i, "omega_max": omega_max},
        "u_inj": motor.u_inj,
        "i_floor": floor,
        "n_hold": max(1.0, round(hold / motor.T_s)),
        "lead": 0.5 if delay_cure else -1.0,
        "alpha_rise": low_pass(RISE_OVER * natural_hz, motor.T_s),
        "err_rise": low,
        "rise": RISE_MAX / (high - low),
        "rise_max": RISE_MAX if normalised else 0.0,
        "scheme": SCHEMES[scheme],
    }

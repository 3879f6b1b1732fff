"""How well injection sees the rotor: signal against noise and converter steps, over current."""

import math
from dataclasses import dataclass, replace

import numpy as np

from sensorless.machine.inverter import threshold_voltage
from sensorless.machine.magnetics import Floats, mtpa
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import principal

SENSOR_NOISE = (0.002, 0.012)
"""Least and largest noise of a current sensor on a machine rated at ``NOISE_AT``, RMS [A]; every
other machine's is as large over its rated current."""
NOISE_AT = 5.63
"""Rated current of the source paper's machine [A]."""
NOISE = 0.0012
"""Current noise expected of a sensor, RMS over rated current: the mean of ``SENSOR_NOISE``."""
NOISE_SHARE = 0.7
"""Least error of a sample that gains count on, over that noise."""
NOISE_DEG = 1.0
"""RMS angle noise that the voltage is chosen for, at the worst current up to rated [deg]."""
STEP_DEG = 10.0
"""Angle of one step of the converter that it is chosen for [deg]; the loop averages steps."""
LINK_SHARE = 0.2
"""Largest injected voltage over the DC link; the limit of the source paper."""
RIPPLE_SHARE = 0.2
"""Largest injected current over rated current; more would load the machine itself."""
LOST_SHARE, BY_SALIENCY = 2.0, 1.3
"""Least injected voltage over what dead time and the switches' thresholds take; with less it falls
into the dead band. What they take also turns the angle, by more where the saliency is small: the
second over 1 - L_d/L_q, the slope of injection's error. Of twelve random machines that this gives
more than twice, one of L_q/L_d = 1.5 lost 1 to 2 % of ``unload`` and ``stress`` with twice and now
none, and none had more angle error; a spindle of 1.36 lost 10 and 2 %, and now none."""


@dataclass(frozen=True)
class InjectionSignal:
    """What the injection loop sees along the operating line, one row per current."""

    i: Floats
    """(n, 2) currents from zero to ``i_max`` [A]"""
    ratio: Floats
    """(n,) larger over smaller incremental inductance"""
    slope: Floats
    """(n,) current across the injected axis per radian of angle error [A/rad]"""
    noise_deg: Floats
    """(n,) RMS of the estimated angle [deg]"""
    step_deg: Floats
    """(n,) angle error of one step of the converter [deg]"""
    amplitude: float
    """largest amplitude of the injected current [A]"""


def injection_signal(motor: Motor, pll_hz: float) -> InjectionSignal:
    """Signal and noise of square-wave injection at currents of maximum torque per ampere.

    Voltage u along an axis for one period moves the current by u T_s / L of that axis, half of it
    to either side of the mean. An angle error moves ``u T_s / 2 (1 / L_small - 1 / L_large)`` [A]
    per radian onto the other axis. White noise sigma of each sample, which includes step / sqrt(12)
    of the converter, passes the loop of noise bandwidth B = 0.53 w_n as
    ``sigma sqrt(2 B T_s) / slope``.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the injection loop [Hz].
    """
    i = mtpa(motor)
    small, large = principal(motor, i).T
    half = 0.5 * motor.u_inj * motor.T_s
    slope = half * (1.0 / small - 1.0 / large)
    lsb, sigma = adc_step(motor), sample_noise(motor)
    band = 0.53 * 2.0 * math.pi * pll_hz
    tiny = 1e-300  # its inverse is finite, in degrees too
    per_ampere = np.rad2deg(1.0 / np.maximum(slope, tiny))
    return InjectionSignal(
        i=i,
        ratio=large / small,
        slope=slope,
        noise_deg=sigma * math.sqrt(2.0 * band * motor.T_s) * per_ampere,
        step_deg=lsb * per_ampere,
        amplitude=float(np.max(half / small)),
    )


def adc_step(motor: Motor) -> float:
    """One step of the current measurement [A]."""
    return motor.adc_range * 2.0 ** (1 - motor.adc_bits)


def sample_noise(motor: Motor, sensor: float = NOISE) -> float:
    """Noise of a current sample, its rounding included, RMS [A]; ``sensor``: over rated current."""
    return math.hypot(sensor * motor.i_rated, adc_step(motor) / math.sqrt(12.0))


def sample_error(motor: Motor) -> float:
    """Error of a current sample that gains count on [A]: a step of the converter, or the noise.

    A finer converter makes no sensor quieter. ``NOISE_SHARE`` of ``NOISE`` is the step of 12 bits
    over twice the rated current, less a seventh.
    """
    return max(adc_step(motor), NOISE_SHARE * NOISE * motor.i_rated)


def suggested_injection(motor: Motor, pll_hz: float) -> float:
    """Injected voltage [V], two digits: enough for noise, converter and inverter, within limits.

    ``NOISE_DEG``, ``STEP_DEG``, ``LOST_SHARE`` and ``BY_SALIENCY`` say what is enough; limits are
    ``LINK_SHARE`` of the DC link and ``RIPPLE_SHARE`` of rated current.
    """
    one = injection_signal(replace(motor, u_inj=1.0), pll_hz)
    rated = np.hypot(*one.i.T) <= motor.i_rated
    salient = max(1.0 - 1.0 / float(one.ratio[rated].min()), 1e-9)  # slope of injection's error
    share = max(LOST_SHARE, BY_SALIENCY / salient)
    wanted = max(
        float(one.noise_deg[rated].max()) / NOISE_DEG,
        float(one.step_deg[rated].max()) / STEP_DEG,
        share * (motor.dead_time_voltage + threshold_voltage(motor)),
    )
    most = min(LINK_SHARE * motor.u_dc, RIPPLE_SHARE * motor.i_rated / one.amplitude)
    volt = min(wanted, most)
    rounded = float(f"{volt:.2g}")
    if rounded > most:
        rounded -= 10.0 ** (math.floor(math.log10(volt)) - 1)
    return float(f"{rounded:.2g}")

"""What the drive accepts as an input: ``guard_params_t`` from the machine."""

import math
from typing import Any

from sensorless.machine.motor import Motor
from sensorless.observers.injection_signal import sample_noise
from sensorless.observers.tracking import speed_dip

ABOVE_RANGE = 1.1
"""Largest plausible sample over the converter's range: calibrated gain and offset of a channel move
a full reading by a few percent, and no channel reads more."""
IN_RANGE = 0.98
"""Over-current limit over the converter's range: a channel that stands at its end, less an offset
of 2 %, measures no more, so the current is unknown and may be anything above."""
STEP = 4.0 / 3.0 * 1.15
"""Voltage over the nominal DC link that changes the current most: from one corner of the inverter's
hexagon to the opposite one, at a link 15 % above, on L_d. Of 2000 drives
of ``stress`` on three shipped machines none that holds comes to it."""
NOISY = 12.5
"""What noise adds to that step, over the noise of a sample: four times the RMS of a difference of
two, sqrt(2), across two phases, sqrt(5/3), with the noisiest sensors of the suites, 1.7. It counts
where a period moves the current by a few steps of the converter."""
LINK = (0.5, 1.5)
"""Least and largest DC-link voltage over the nominal one. A rectified mains within its tolerance
stays within 0.85 and 1.15, a brake chopper works below 1.4; below half, the drive has a quarter of
its power and no voltage for injection at load."""
OUTPUT = 1.5
"""Bound on a component of the voltage over the largest DC link: the control stays within 0.58 of
the link, and injection and dead-time compensation, each less than the link, come on top."""
HEADROOM = 0.5
"""Largest speed reference over the bound of the speed estimates, where a rated load that goes takes
the shaft farther than the rest."""
SPEED_MOST = 1e5
"""Electrical [rad/s]; beyond, an angle moves by more than a turn in a period of most drives."""


def reference_bound(motor: Motor, omega_max: float, speed_hz: float) -> float:
    """Largest speed reference, electrical [rad/s].

    An estimate at its bound no longer tells how fast the shaft is, which then runs away. So the
    bound of the reference is less by what a rated load that goes makes of the speed, ``speed_dip``.
    """
    rise = speed_dip(motor, 2.0 * math.pi * speed_hz)
    return min(max(omega_max - rise, HEADROOM * omega_max), SPEED_MOST)


def design_guard(motor: Motor, omega_max: float, speed_hz: float) -> dict[str, Any]:
    """Fields of ``guard_params_t``.

    Parameters
    ----------
    omega_max : float
        Bound of the speed estimates, electrical [rad/s].
    speed_hz : float
        Natural frequency of the speed loop [Hz].
    """
    return {
        "i_sample": ABOVE_RANGE * motor.adc_range,
        "i_over_sq": min(motor.i_trip, IN_RANGE * motor.adc_range) ** 2,
        "i_step_sq": (STEP * motor.u_dc * motor.T_s / motor.L_d + NOISY * sample_noise(motor)) ** 2,
        "u_dc_min": LINK[0] * motor.u_dc,
        "u_dc_max": LINK[1] * motor.u_dc,
        "u_out": OUTPUT * LINK[1] * motor.u_dc,
        "omega": reference_bound(motor, omega_max, speed_hz),
    }

"""How fast an estimator should follow: acceleration against noise, from the machine file.

An acceleration of ``rated_acceleration`` a changes ``CHANGES`` times a second at random, and each
sample of the angle has white noise of standard deviation sigma. The steady-state Kalman filter of
angle, speed and acceleration then has three poles of magnitude W,

    W^3 = a sqrt(CHANGES) / (sigma sqrt(T_s))

(Kalata's tracking index, doi 10.1109/TAES.1984.310438). docs/gains.md lists all that follows.
"""

import math

from sensorless.machine.motor import Motor
from sensorless.observers.hfi_design import error_slope, hf_current
from sensorless.observers.injection_signal import sample_error

CHANGES = 1.0
"""Rated changes of the load, and full changes of the dead time's voltage, per second [1/s]."""
SAMPLE_ERRORS = 3.0
"""Error of a current sample by noise, offset and gain, over ``sample_error``. Injection uses second
differences, whose error is one of it."""

MOST_DEAD_TIME = 1.5
"""Largest dead time over the file's: drivers and switches add delays of their own."""
LEFT_DEAD_TIME = 0.75
"""What is not known of the dead time's voltage: it may be ``MOST_DEAD_TIME`` times the file's and
is compensated by 0.75."""
LEFT_RESISTANCE = 1.0 / 3.0
"""What is not known of the resistance, over the file's: a cold winding's to a hot one's."""
CHANGING = 0.5
"""Share of that by which a rated load turns the flux beside the dead time. With all of it the
injection's noise swings machines at a steady load that lose nothing: docs/coupled-gains.md."""

HAND_OVER = 0.2
"""Speed at which Eq. 25 leaves injection, over rated."""
LEAST_DEAD_TIME = 1e-3
"""Least dead time of an inverter, over a period: stands for a dead time of zero."""
LEAST_SLOPE = 1e-6
"""Stands for a slope of the error signal that is zero or negative: no saliency, no signal."""


def rated_acceleration(motor: Motor) -> float:
    """Acceleration by rated torque on the machine's own inertia, electrical [rad/s^2]."""
    return motor.n_p * motor.tau_rated / motor.J


def speed_dip(motor: Motor, w: float) -> float:
    """Dip of the speed after a step of rated torque, electrical [rad/s].

    The IP speed loop with a double pole at w [rad/s] dips by tau / (J w e).
    """
    return rated_acceleration(motor) / (math.e * w)


def voltage_drift(motor: Motor) -> float:
    """Rate at which the uncompensated dead time of one leg turns the flux [rad/s].

    Three legs make 4/pi of it on average, and 4/3 at most. The bandwidths were tried with one.
    """
    return motor.u_dc * max(motor.dead_time / motor.T_s, LEAST_DEAD_TIME) / motor.psi_f


def resistance_drift(motor: Motor) -> float:
    """Rate at which ``LEFT_RESISTANCE`` at rated current turns the flux [rad/s]."""
    return LEFT_RESISTANCE * motor.R_s * motor.i_rated / motor.psi_f


def unknown_drift(motor: Motor) -> float:
    """Rate at which what is not known of the voltage turns the flux, at rated current [rad/s]."""
    return LEFT_DEAD_TIME * voltage_drift(motor) + resistance_drift(motor)


def flux_noise(motor: Motor) -> float:
    """Noise of the flux angle of a sample [rad]: L_q ``SAMPLE_ERRORS`` of it over psi_f."""
    return motor.L_q * SAMPLE_ERRORS * sample_error(motor) / motor.psi_f


def dead_time_noise(motor: Motor) -> float:
    """Angle [rad] by which a period's dead time of one leg turns the flux."""
    return motor.u_dc * motor.dead_time / motor.psi_f


def injection_noise(motor: Motor) -> float:
    """Noise of the injection's angle of a sample [rad]: its error over the slope of the answer."""
    slope = max(error_slope(motor.L_d, motor.L_q), LEAST_SLOPE)
    return sample_error(motor) / (hf_current(motor) * slope)


def injection_bandwidth(motor: Motor) -> float:
    """W of the injection's double pole [rad/s], for the larger drift of the flux.

    That of the dead time, or ``CHANGING`` of the resistance's.
    """
    return bandwidth(motor, max(voltage_drift(motor), CHANGING * resistance_drift(motor)))


def bandwidth(motor: Motor, drift: float) -> float:
    """W of the injection's double pole [rad/s]: steady-state Kalman gains, as of ``tracking``.

    A drift of v = ``drift`` [rad/s] changes as often as the acceleration; with ``injection_noise``
    sigma, W^2 = v sqrt(CHANGES) / (sigma sqrt(T_s)) / 2.
    """
    often = math.sqrt(CHANGES / motor.T_s)
    return math.sqrt(0.5 * drift * often / injection_noise(motor))


def tracking(motor: Motor, noise: float) -> float:
    """W of this module's formula [rad/s] for angles with ``noise`` [rad]."""
    steps = math.sqrt(CHANGES / motor.T_s)
    return float((rated_acceleration(motor) * steps / noise) ** (1.0 / 3.0))

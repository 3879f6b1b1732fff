"""Whether injection pulls an angle error back where the iron saturates.

The control holds the current in the estimated frame. Where the estimate is off, the rotor sees it
turned by that error; with it turns the iron's point of work, and so the axes of least and largest
inductance. What injection sees is then less than the error, or of the other sign: nothing brings
the drive back. The saliency along the operating line, where there is no error, does not show that.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.machine.magnetics import Floats, cross_angle, flux, inverse_inductance
from sensorless.machine.motor import Motor

ERRORS = np.radians(np.concatenate([np.arange(-20.0, 0.0), np.arange(1.0, 21.0)]))
"""Angle errors [rad] that steps of load and braking make in drives that hold."""


def pulled_back(motor: Motor, i: Floats) -> Floats:
    """Least share of an angle error that injection sees, of ``ERRORS``, at currents i (n, 2) [A].

    1 for small errors on a linear machine; from 0 down injection does not pull back.
    """
    axis = -cross_angle(motor, i)  # of injection, in the estimated frame
    shares = []
    for error in ERRORS:
        turned = i @ _rotation(np.array([error]))[0]  # by -error: the rotor is ahead
        gamma = inverse_inductance(motor.saturation, flux(motor.saturation, turned))
        back = _rotation(error - axis)  # from the rotor's frame to that of injection
        seen = back @ gamma @ back.swapaxes(1, 2)
        shares.append(seen[:, 1, 0] / np.hypot(seen[:, 0, 0], seen[:, 1, 0]) / error)
    return np.asarray(np.min(shares, axis=0) / max(1.0 - motor.L_d / motor.L_q, 1e-9))


def _rotation(angle: Floats) -> NDArray[np.float64]:
    """(n, 2, 2) matrices that turn by angles (n,) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)

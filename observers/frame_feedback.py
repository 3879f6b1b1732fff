"""How much injection answers the corrections of its own frame.

Its error e is found in the second difference of three samples, each in the frame of its instant. A
correction phi of the angle turns a d current I that does not alternate by -phi I along q, and the
sign of the injection makes an answer of that:

    e'_k = e_k - (-1)^k (I / (4 i_h)) (phi_k - 2 phi_(k-1) + phi_(k-2))
    phi_(k+1) = phi_k + K e'_k

with the injected current i_h and the gain K of a correction. What repeats every four periods,
z j^k + z* (-j)^k, becomes -j z + 2 gamma z*, with

    gamma = K |I| / (4 i_h)

The square of that is a factor of 4 gamma^2 - 1, so it grows beyond gamma = 1/sqrt(2): angle,
current and answer swing at a quarter of the PWM frequency.
"""

import math

import numpy as np

from sensorless.machine.magnetics import cross_angle, mtpa
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import principal
from sensorless.observers.hfi_design import error_slope
from sensorless.observers.tracking import injection_bandwidth

MOST = 1.0 / math.sqrt(2.0)
"""gamma beyond which it swings."""


def frame_feedback(motor: Motor) -> float:
    """Largest gamma of the coupled observer up to ``i_max``, of a machine that is salient."""
    i = np.stack(mtpa(motor), axis=-1)
    cross = cross_angle(motor, i)
    along = np.abs(i[:, 0] * np.cos(cross) - i[:, 1] * np.sin(cross))
    injected = 0.5 * motor.T_s * motor.u_inj / principal(motor, i)[:, 0]
    gain = 2.0 * injection_bandwidth(motor) * motor.T_s / error_slope(motor.L_d, motor.L_q)
    return float(np.max(0.25 * gain * along / injected))

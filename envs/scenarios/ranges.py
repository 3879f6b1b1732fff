"""What is uncertain about a drive and by how much; every suite draws from the same ranges."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Floats
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor
from sensorless.observers.injection_signal import NOISE_AT, SENSOR_NOISE

R_S = (0.75, 1.40)
"""Resistance over the controller's value: a winding from cold to hot."""
PSI_F = (0.94, 1.06)
"""Magnet strength over its nominal value."""
L_Q_HAT = (0.75, 1.10)
"""Observer's q inductance over its design value."""
CROSS_HAT = (0.6, 1.4)
"""Cross-coupling compensation over its design value."""
INERTIA = (0.5, 3.0)
"""Over its nominal value, uniform in the logarithm."""
DEAD_TIME = (0.25, 1.5)
"""Over the motor file's."""
GAIN = 0.02
"""Largest error of a current channel's gain, of either sign."""
OFFSET = 0.005
"""Largest offset of a current channel over rated current, of either sign."""

R_S_COLD = (0.95, 1.05)
PSI_F_COLD = (0.97, 1.03)
"""The same at the temperature at which the controller's values were taken: tolerances."""
WINDING_K = (-30.0, 105.0)
"""Winding above that temperature: from frost to the rise of insulation class F [K]."""
MAGNET_SHARE = (0.3, 0.8)
"""Rise of the magnet over that of the winding."""
EMF_5, EMF_7 = 0.03, 0.02
"""Largest harmonics of the EMF over its fundamental, of either sign."""
SALIENCY_6 = 0.05
"""Largest second saliency over the first, of either sign."""
IRON = (0.005, 0.03)
"""Iron loss at rated speed without load over rated power."""
IRON_LOADED = 0.06
"""Most that it is under rated load: half of what a machine of 88 % efficiency loses."""
RIPPLE = (0.0, 0.03)
"""Amplitude over the link; six pulses a period of a three-phase mains of 50 or 60 Hz."""


def by_turns(indices: NDArray[np.int64]) -> Floats:
    """(n,) 1 for even rows of a suite and -1 for odd ones."""
    return np.where(indices % 2 == 0, 1.0, -1.0)


def any_inertia(d: Draws) -> Floats:
    """Inertia over nominal, 0.5 to 3."""
    return np.asarray(np.exp(d.uniform(*np.log(INERTIA))))


def add_errors(s: Scenarios, d: Draws, motor: Motor) -> None:
    """Draw all in which plant and sensors leave what the controller takes them for."""
    s.R_s = d.uniform(*R_S)
    s.L_q_hat = d.uniform(*L_Q_HAT)
    s.psi_f = d.uniform(*PSI_F)
    s.J = any_inertia(d)
    s.cross_hat = d.uniform(*CROSS_HAT)
    s.dead_time = d.uniform(*DEAD_TIME) * motor.dead_time
    add_sensor_errors(s, d, motor)


def add_sensor_errors(s: Scenarios, d: Draws, motor: Motor) -> None:
    """Draw noise, gains and offsets of the current channels."""
    s.noise = d.uniform(*SENSOR_NOISE) * (motor.i_rated / NOISE_AT)
    s.gain = 1.0 + np.stack([d.uniform(-GAIN, GAIN), d.uniform(-GAIN, GAIN)], axis=-1)
    s.offset = OFFSET * motor.i_rated * np.stack([d.uniform(-1, 1), d.uniform(-1, 1)], axis=-1)

"""What is uncertain about a drive and by how much; every suite draws from the same ranges."""

import numpy as np

from sensorless.envs.counter_random import Draws, Floats

R_S = (0.75, 1.40)
"""Resistance over the controller's value: a winding from cold to hot."""
PSI_F = (0.94, 1.06)
"""Magnet strength over its nominal value."""
INERTIA = (0.5, 3.0)
"""Over its nominal value, uniform in the logarithm."""
DEAD_TIME = (0.25, 1.5)
"""Over the motor file's."""


def any_inertia(d: Draws) -> Floats:
    """Inertia over nominal, 0.5 to 3."""
    return np.asarray(np.exp(d.uniform(*np.log(INERTIA))))

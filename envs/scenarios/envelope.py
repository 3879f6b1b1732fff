"""A grid of speed and load, for the map of where a policy holds lock."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

Indices = NDArray[np.int64]


def envelope_scenarios(motor: Motor, seeds: Seeds, indices: Indices, size: int) -> Scenarios:
    """A square grid of speed (rows) and load (columns) from -100 to 100 %, in row-major order.

    The drive starts at its speed, then the load rises within 0.2 s and stays for 0.6 s.
    """
    side = int(np.sqrt(size))
    grid = np.linspace(-1.0, 1.0, side)
    speed, load = grid[indices // side], grid[indices % side]
    s = Scenarios.nominal(motor, seeds, 1.0)
    omega = speed * motor.omega_rated / motor.n_p
    s.omega_0[:] = omega
    s.omega[:] = omega[:, None]
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = load[:, None] * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.2
    return s

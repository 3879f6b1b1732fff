"""Steps of the speed through zero at once: ``reversal``."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Seeds
from sensorless.envs.scenarios.ranges import any_inertia, by_turns
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor


def reversal_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """From 30 to 100 % of rated speed to as much of the other direction, under a load.

    The drive starts at that speed, its direction alternating by row. From 0.1 s a load of up to
    rated torque rises within 50 ms and stays: it brakes before the step and drives after it, or, in
    every second pair of rows, the other way round. At 0.4 s the reference steps at once. Inertia
    0.5 to 3 times nominal, all else nominal.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 1.6)
    s.detailed[:] = True
    way = by_turns(indices)
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    s.omega_0 = way * d.uniform(0.3, 1.0) * motor.omega_rated / motor.n_p
    after = -way * d.uniform(0.3, 1.0) * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1], s.t[:, 2] = 0.1, 0.4
    s.omega[:, 2:] = after[:, None]
    s.omega_rate[:] = 1e6 * motor.omega_rated
    side = by_turns(indices // 2) * way
    s.tau[:, 1:] = (side * d.uniform(0.0, 1.0) * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.05
    return s

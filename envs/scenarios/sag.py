"""A DC link that sags under a loaded drive: the suite ``sag``."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Seeds
from sensorless.envs.scenarios.ranges import add_errors, by_turns
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

LEFT = (0.7, 0.95)
"""Voltage that is left, over nominal: dips of the mains that a drive should ride through."""
LASTS = (0.05, 0.5)
"""[s]"""
BEGINS = 0.6
"""[s]"""


def sag_scenarios(motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object) -> Scenarios:
    """The link falls to 70 to 95 % within 10 ms, for 50 to 500 ms, at 50 to 100 % of rated speed.

    The drive starts at that speed, its direction alternating by row; a load of up to rated torque
    comes within 0.1 s from 0.05 s on, drives the shaft in a fifth of the rows and stays until the
    end. Parameters, inertia and sensors are off by as much as in ``stress-1``.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 2.0)
    s.detailed[:] = True
    add_errors(s, d, motor)
    s.theta_0 = d.uniform(-np.pi, np.pi)
    way = by_turns(indices)
    s.omega_0 = way * d.uniform(0.5, 1.0) * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1], s.t[:, 2] = 0.05, BEGINS
    s.t[:, 3] = BEGINS + d.uniform(*LASTS)
    drives = np.where(d.chance(0.2), -way, way)
    s.tau[:, 1:] = (drives * d.uniform(0.0, 1.0) * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.1
    s.u_dc[:, 2] = d.uniform(*LEFT)
    return s

"""Load at low speed, where injection leads: ``hold``, ``crawl`` and ``braking``."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Seeds
from sensorless.envs.scenarios.ranges import add_errors, any_inertia, by_turns
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

HOLD_SPEEDS = (0.0, 5.0 / 1500.0, -5.0 / 1500.0, 20.0 / 1500.0, -20.0 / 1500.0)
"""Over rated: standstill, 5 and 20 r/min of a machine for 1500."""
HOLD_TIME = 10.0
"""[s]"""
BRAKING_SPEEDS = (0.02, 0.3)
"""Over rated: up to half again the speed at which Eq. 25 begins to end injection."""


def hold_scenarios(motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object) -> Scenarios:
    """Rated torque for 10 s at a speed of ``HOLD_SPEEDS``, ten rows in turn: each with both signs.

    The drive starts at that speed and any angle; from 0.2 s the load rises within 0.1 s and stays
    until the end. Inertia 0.5 to 3 times nominal, all else nominal.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 0.3 + HOLD_TIME)
    s.detailed[:] = True
    speed = np.array(HOLD_SPEEDS)[indices // 2 % len(HOLD_SPEEDS)]
    sign = by_turns(indices)
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    s.omega_0 = speed * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = (sign * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.1
    return s


def crawl_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """Three slow reversals through zero under a load of 25 to 100 %, its sign alternating by row.

    The speed runs between plus and minus 1 to 4 % of rated (15 to 60 r/min of 1500), each reversal
    on a ramp of 0.4 to 1.2 s; the load rises within 0.1 s from 0.2 s and stays. Inertia 0.5 to 3
    times nominal, all else nominal.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 6.5)
    s.detailed[:] = True
    top = d.uniform(0.01, 0.04) * motor.omega_rated / motor.n_p
    top *= np.where(d.chance(0.5), 1.0, -1.0)
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    sign = by_turns(indices)
    s.omega_0 = top
    s.omega[:] = top[:, None]
    for j, start in enumerate((1.0, 2.8, 4.6), start=2):
        s.t[:, j] = start
        s.omega[:, j:] = (top if j % 2 else -top)[:, None]
    s.omega_rate[:] = (2.0 * np.abs(top) / d.uniform(0.4, 1.2))[:, None]
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = (sign * d.uniform(0.25, 1.0) * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.1
    return s


def braking_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """A load of 50 to 100 % that drives the shaft, held for 2 s at 2 to 30 % of rated speed.

    The drive is a generator with next to no EMF. It starts at that speed, its direction
    alternating by row; from 0.2 s the load rises within 2 to 300 ms and stays. Parameters, inertia
    and sensors are off by as much as in ``stress-1``.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 2.2)
    s.detailed[:] = True
    add_errors(s, d, motor)
    s.theta_0 = d.uniform(-np.pi, np.pi)
    way = by_turns(indices)
    s.omega_0 = way * d.uniform(*BRAKING_SPEEDS) * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = (-way * d.uniform(0.5, 1.0) * motor.tau_rated)[:, None]
    s.tau_rate[:] = (motor.tau_rated / np.exp(d.uniform(np.log(0.002), np.log(0.3))))[:, None]
    return s

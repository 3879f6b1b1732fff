"""Loads that come and go suddenly, and stops under load: ``impact``, ``stop`` and ``unload``."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Seeds
from sensorless.envs.scenarios.ranges import DEAD_TIME, PSI_F, R_S, any_inertia, by_turns
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

IMPACT_TIME = 0.002
"""Rise of the rated load in ``impact`` [s]."""
IMPACT_SPEEDS = 11
"""Speeds from zero to rated."""
UNLOAD = (40.0 / 1500.0, 250.0 / 1500.0)
"""Speeds over rated at which ``unload`` takes its loads off: 40 to 250 r/min of 1500."""


def impact_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """Rated load on and off within 2 ms, at 0 to 100 % of rated speed in steps of 10 %.

    44 rows in turn: speeds, both directions, both signs. The load comes at 0.3 s and goes at 1.6 s;
    3 s in all. Inertia 0.5 to 3 times nominal, all else nominal.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 3.0)
    s.detailed[:] = True
    speed = indices // 4 % IMPACT_SPEEDS / (IMPACT_SPEEDS - 1)
    way = by_turns(indices)
    sign = by_turns(indices // 2)
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    s.omega_0 = way * speed * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1], s.t[:, 2] = 0.3, 1.6
    s.tau[:, 1] = sign * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / IMPACT_TIME
    return s


def stop_scenarios(motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object) -> Scenarios:
    """From rated speed to zero under a load of 25 to 100 %, directions and signs in turn by row.

    The load rises within 50 ms from 0.2 s; from 0.7 s the reference falls with 20 to 80 % of rated
    torque on the inertia at hand, and the drive then stands under its load for 1.5 s. Inertia 0.5
    to 3 times nominal, all else nominal.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 1.0)
    s.detailed[:] = True
    way = by_turns(indices)
    sign = by_turns(indices // 2)
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    rated = motor.omega_m_rated
    s.omega_0 = way * rated
    s.omega[:, :2] = s.omega_0[:, None]
    s.t[:, 1], s.t[:, 2] = 0.2, 0.7
    s.tau[:, 1:] = (sign * d.uniform(0.25, 1.0) * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.05
    rate = d.uniform(0.2, 0.8) * motor.tau_rated / (motor.J * s.J)
    s.omega_rate[:] = rate[:, None]
    s.duration = 0.7 + rated / rate + 1.5
    return s


def unload_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """A load of 25 to 100 % taken off at the speeds of ``UNLOAD``, directions and signs in turn.

    The load comes within 50 ms at 0.2 s and goes within 2 to 50 ms at 1.0 s; 2.5 s in all. Magnet,
    resistance, dead time and inertia in the ranges of ``stress-1``; exact sensors and inductances.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 2.5)
    s.detailed[:] = True
    way = by_turns(indices)
    sign = by_turns(indices // 2)
    s.R_s, s.psi_f = d.uniform(*R_S), d.uniform(*PSI_F)
    s.dead_time = d.uniform(*DEAD_TIME) * motor.dead_time
    s.J, s.theta_0 = any_inertia(d), d.uniform(-np.pi, np.pi)
    s.omega_0 = way * d.uniform(*UNLOAD) * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1], s.t[:, 2] = 0.2, 1.0
    s.tau[:, 1] = sign * d.uniform(0.25, 1.0) * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.05
    off = np.exp(d.uniform(np.log(0.002), np.log(0.05)))
    s.tau_rate[:, 2:] = (motor.tau_rated / off)[:, None]
    return s

"""Starts from an unknown angle: standing and spinning shafts, under load."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Draws, Seeds
from sensorless.envs.scenarios.ranges import DEAD_TIME, PSI_F, R_S, add_sensor_errors, any_inertia
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

HALF_LOAD = 0.5
"""Largest load over rated torque."""
BEGIN = 0.1
"""Speed target after the start sequence [s]."""


def starts_scenarios(
    motor: Motor, seeds: Seeds, indices: NDArray[np.int64], *_: object
) -> Scenarios:
    """The rotor at any angle; every second row has its first estimate 180 degrees off.

    Eight rows in turn, two of each kind: at rest without load; at rest with a load of up to half
    the rated torque in either direction, which moves the shaft until the drive knows its rotor; at
    rest with an equally large load that only resists, like friction; and on a shaft that spins at
    up to rated speed, with a load that drives the shaft. From 0.1 s on the speed runs to a target
    of 10 to 40 % of rated in either direction, on a ramp of 30 % of rated torque. The first
    estimate is up to 90 degrees off, in every second row plus half a turn. Inertia, magnet,
    resistance, dead time and sensors are as uncertain as in
    ``stress-1``.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, 1.2)
    omega_rated = motor.omega_m_rated
    active, passive, spins = (indices // 2 % 4 == kind for kind in (1, 2, 3))

    s.seek[:] = True
    s.passive[:] = passive
    s.theta_0 = d.uniform(-np.pi, np.pi)
    s.theta_err_0 = d.uniform(-0.5, 0.5) * np.pi + np.where(indices % 2 == 1, np.pi, 0.0)
    load = d.uniform(0.0, HALF_LOAD) * motor.tau_rated
    sign = np.where(d.chance(0.5), 1.0, -1.0)
    s.tau[:] = np.where(active | spins, sign * load, np.where(passive, load, 0.0))[:, None]
    s.omega_0 = np.where(spins, d.uniform(-1.0, 1.0) * omega_rated, 0.0)
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1] = BEGIN
    way = np.where(d.chance(0.5), 1.0, -1.0)
    s.omega[:, 1:] = (way * d.uniform(0.1, 0.4) * omega_rated)[:, None]

    s.R_s = d.uniform(*R_S)
    s.psi_f = d.uniform(*PSI_F)
    s.J = any_inertia(d)
    s.dead_time = d.uniform(*DEAD_TIME) * motor.dead_time
    add_sensor_errors(s, d, motor)
    s.omega_rate[:] = (0.3 * motor.tau_rated / (motor.J * s.J))[:, None]
    return s

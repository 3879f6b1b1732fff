"""Everything at random: what training draws from and what the stress suite judges on."""

import numpy as np

from sensorless.envs.counter_random import Draws, Floats, Seeds
from sensorless.envs.scenarios.ranges import DEAD_TIME, PSI_F, R_S, any_inertia
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor

DURATION = 2.0
"""[s]"""


def stress_scenarios(motor: Motor, seeds: Seeds) -> Scenarios:
    """Random profiles on a random machine; row i is a function of ``seeds[i]`` alone.

    Half of the drives start at rest, half on a spinning shaft; then two speed targets over the
    whole range of both directions, two loads over the whole range of both signs, and a sag of the
    DC link. Ramps ask for 10 to 60 % of rated torque on the inertia at hand; loads rise within 2 to
    300 ms. Plant and controller differ in resistance, q inductance, magnet, inertia,
    cross-coupling and dead time, and the current sensors have noise, gain and offset errors.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, seeds, DURATION)
    omega_rated = motor.omega_rated / motor.n_p

    s.R_s = d.uniform(*R_S)
    s.L_q_hat = d.uniform(0.75, 1.10)
    s.psi_f = d.uniform(*PSI_F)
    s.J = any_inertia(d)
    s.cross_hat = d.uniform(0.6, 1.4)
    s.dead_time = d.uniform(*DEAD_TIME) * motor.dead_time
    s.noise = d.uniform(0.002, 0.012) * (motor.i_rated / 5.63)
    s.gain = 1.0 + np.stack([d.uniform(-0.02, 0.02), d.uniform(-0.02, 0.02)], axis=-1)
    s.offset = 0.005 * motor.i_rated * np.stack([d.uniform(-1, 1), d.uniform(-1, 1)], axis=-1)

    s.omega_0 = np.where(d.chance(0.5), 0.0, d.uniform(-1.0, 1.0) * omega_rated)
    s.theta_0 = d.uniform(-np.pi, np.pi)
    s.theta_err_0 = d.uniform(-1.0, 1.0) * np.deg2rad(10.0)

    events = (
        ("omega", d.uniform(0.05, 0.30), d.uniform(-1.0, 1.0) * omega_rated),
        ("tau", d.uniform(0.10, 0.50), d.uniform(-1.0, 1.0) * motor.tau_rated),
        ("omega", d.uniform(0.80, 1.30), d.uniform(-1.0, 1.0) * omega_rated),
        ("tau", d.uniform(0.90, 1.60), d.uniform(-1.0, 1.0) * motor.tau_rated),
        ("u_dc", d.uniform(0.60, 1.40), d.uniform(0.88, 1.0)),
    )
    _lay_out(s, events)
    inertia = motor.J * s.J
    s.omega_rate = np.broadcast_to(
        (d.uniform(0.10, 0.60) * motor.tau_rated / inertia)[:, None], s.omega_rate.shape
    ).copy()
    rise = np.exp(d.uniform(np.log(0.002), np.log(0.3)))
    s.tau_rate = np.broadcast_to((motor.tau_rated / rise)[:, None], s.tau_rate.shape).copy()
    return s


def _lay_out(s: Scenarios, events: tuple[tuple[str, Floats, Floats], ...]) -> None:
    """Sort the events (what, when, target) of every row by time and fill the profile's segments."""
    times = np.stack([when for _, when, _ in events], axis=-1)
    order = np.argsort(times, axis=-1, kind="stable")
    rows = np.arange(len(s))
    s.omega[:] = s.omega_0[:, None]
    for column in range(len(events)):
        which = order[:, column]
        s.t[:, column + 1] = times[rows, which]
        for j, (what, _, target) in enumerate(events):
            hit = which == j
            getattr(s, what)[hit, column + 1 :] = target[hit, None]


def nominal_scenarios(motor: Motor, seeds: Seeds, *_: object) -> Scenarios:
    """The profiles of ``stress`` on a drive that knows its machine and has good sensors."""
    s = stress_scenarios(motor, seeds)
    exact = Scenarios.nominal(motor, seeds, 1.0)
    for name in (
        "R_s",
        "L_q_hat",
        "psi_f",
        "J",
        "cross_hat",
        "dead_time",
        "noise",
        "gain",
        "offset",
    ):
        setattr(s, name, getattr(exact, name))
    s.u_dc[:] = 1.0
    return s

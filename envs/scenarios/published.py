"""The figures of the source paper, doi 10.12177/emca.2025.011."""

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Floats, Seeds
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

Indices = NDArray[np.int64]


def paper_scenarios(motor: Motor, seeds: Seeds, indices: Indices, _: int) -> Scenarios:
    """Figs. 9, 13/14 and 11 of doi 10.12177/emca.2025.011 in turn, speeds relative to 1500 r/min.

    Fig. 9: 200, 350, 600 r/min in steps without load. Figs. 13/14: 150, 350, 650 and back on ramps
    of 600 r/min/s. Fig. 11: 150 r/min, 6 N m (43 % of rated torque).
    """
    s = Scenarios.nominal(motor, seeds, 4.0)
    base = motor.n_rated_rpm / 1500.0 * RPM_TO_RAD_S
    kind = indices % 3
    steps = kind == 0
    _plan(s, steps, [(0.0, 200), (1.0, 350), (2.0, 600)], base)
    _plan(s, kind == 1, [(0.0, 150), (0.8, 350), (1.6, 650), (2.4, 350), (3.2, 150)], base)
    _plan(s, kind == 2, [(0.0, 150)], base)
    s.omega_rate[~steps] = 600.0 * base
    s.duration[steps] = 3.0
    s.tau[kind == 2, 1:] = 6.0 / 14.0 * motor.tau_rated
    s.t[kind == 2, 1] = 1.0
    s.tau_rate[:] = motor.tau_rated / 0.1
    return s


def _plan(s: Scenarios, rows: Floats, plan: list[tuple[float, float]], base: float) -> None:
    """Speed targets (start [s], r/min of a 1500 r/min machine) for the given rows."""
    for j, (start, rpm) in enumerate(plan):
        s.t[rows, j] = start
        s.omega[rows, j:] = rpm * base

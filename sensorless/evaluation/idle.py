"""Swing of a drive without load at constant speed, where dead time is the largest error."""

from dataclasses import replace

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.rollout import are_feasible, rollout
from sensorless.machine.motor import Motor
from sensorless.policy import Policy

SPEEDS = np.array([0.3, 0.4, 0.5, 0.65, 0.8, 1.0])
"""Speeds over rated: above the hand-over of Eq. 25, under which no injection is on."""
DURATION = 1.0
"""Length of a run [s]."""


def idle_swing(motor: Motor, design: DriveDesign, policy: Policy) -> tuple[float, float]:
    """Largest swing of the torque without load, and the speed at which it is.

    It is the RMS deviation from the torque of the sensored twin in the second half of a run, on the
    switching inverter, with a drive that knows its machine exactly.

    Returns
    -------
    swing : float
        over rated torque; NaN if the drive is lost at a speed that it can turn at with an encoder
    speed : float
        over rated speed
    """
    s = Scenarios.nominal(motor, np.arange(len(SPEEDS), dtype=np.uint64), DURATION)
    s.omega_0[:] = SPEEDS * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    r = rollout(policy, s, SimFactory(motor, replace(design, carrier=True)))
    late = r.sums[len(r.sums) // 2 :]
    square = late["dev_lf_sq"].sum(axis=0, dtype=np.float64)
    periods = late["n"].sum(axis=0, dtype=np.float64)
    swing = np.where(r.lost == 0, np.sqrt(square / np.maximum(periods, 1.0)), np.nan)
    swing[~are_feasible(r.lost)] = 0.0
    worst = int(np.argmax(swing))
    return float(swing[worst]) / motor.tau_rated, float(SPEEDS[worst])

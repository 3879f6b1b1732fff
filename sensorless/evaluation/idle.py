"""Swing of a drive without load, where dead time is the largest error."""

from dataclasses import replace

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.rollout import are_feasible, rollout
from sensorless.machine.motor import Motor
from sensorless.policy import Policy

SPEEDS = np.array([0.3, 0.4, 0.5, 0.65, 0.8, 1.0])
"""Speeds over rated: above the hand-over of Eq. 25, under which no injection is on."""
SLOW, LEARNED = 0.15, 0.5
"""Speed over rated at which a run starts, and until when it stays there [s]: under injection, whose
angle error teaches the drive what dead time takes. What it learned is what may make it swing."""
DURATION, LATE = 2.5, 0.75
"""Length of a run, and of its end that counts [s]."""


def idle_swing(motor: Motor, design: DriveDesign, policy: Policy) -> tuple[float, float]:
    """Largest swing of the torque without load, and the speed at which it is.

    It is the RMS deviation from the torque of the sensored twin once the drive has come from
    injection to its speed, on the switching inverter, with a drive that knows its machine exactly.

    Returns
    -------
    swing : float
        over rated torque; NaN if the drive is lost at a speed that it can turn at with an encoder
    speed : float
        over rated speed
    """
    s = Scenarios.nominal(motor, np.arange(len(SPEEDS), dtype=np.uint64), DURATION)
    rated = motor.omega_rated / motor.n_p
    s.omega_0[:] = s.omega[:, 0] = SLOW * rated
    s.t[:, 1] = LEARNED
    s.omega[:, 1:] = rated * SPEEDS[:, None]
    r = rollout(policy, s, SimFactory(motor, replace(design, carrier=True)))
    late = r.sums[-round(LATE / r.decision_time) :]
    square = late["dev_lf_sq"].sum(axis=0, dtype=np.float64)
    periods = late["n"].sum(axis=0, dtype=np.float64)
    swing = np.where(r.lost == 0, np.sqrt(square / np.maximum(periods, 1.0)), np.nan)
    swing[~are_feasible(r.lost)] = 0.0
    worst = int(np.argmax(swing))
    return float(swing[worst]) / motor.tau_rated, float(SPEEDS[worst])

"""Time from one decision of a schedule to the next: one value where it runs, one where it learns.

`RUNNING` is that of firmware, judging, replay and environments. A lookup every millisecond, five
PWM periods of the paper's motor, is short against the signals that a schedule sees (30 Hz). It is
also the step in which the metrics know the torque: in steps of 5 ms the 20 ms mean that the ripple
is measured from follows the torque less, and the same run reads up to a third rougher.

`TRAINING` is longer because it teaches the same for less: a schedule reads slow signals, and every
decision costs a sample and a pass of the critic. docs/how-it-learns.md has the figures.
"""

from sensorless.machine.motor import Motor

RUNNING = 1e-3
"""[s]"""
TRAINING = 5e-3
"""[s]"""


def whole_periods(time: float, motor: Motor) -> int:
    """PWM periods nearest to a time between decisions [s], at least one."""
    return max(1, round(time / motor.T_s))


def decision_periods(motor: Motor) -> int:
    """PWM periods between two decisions where a schedule runs."""
    return whole_periods(RUNNING, motor)


def decision_time(motor: Motor) -> float:
    """Time between two decisions where a schedule runs [s]: whole PWM periods."""
    return decision_periods(motor) * motor.T_s

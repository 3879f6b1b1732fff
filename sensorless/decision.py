"""Time from one decision of a schedule to the next: one value where it runs, one where it learns.

`RUNNING` applies to firmware, evaluation, replay and environments. A lookup every millisecond, five
PWM periods of the paper's motor, is fast for the signals that a schedule sees (30 Hz there). The
metrics also sample the torque at this step: in steps of 5 ms, the 20 ms mean that ripple is
measured against follows the torque less closely, and the ripple of the same run comes out up to a
third larger.

`TRAINING` is longer because it gives the same schedule for less computation: signals are slow, and
every decision costs a sample and a pass of the critic. docs/learning-trials.md has the figures.
"""

from sensorless.machine.motor import Motor

RUNNING = 1e-3
"""Time between decisions where a schedule runs [s]."""
TRAINING = 5e-3
"""Time between decisions in training [s]."""


def whole_periods(time: float, motor: Motor) -> int:
    """PWM periods nearest to a time between decisions [s]; at least one."""
    return max(1, round(time / motor.T_s))


def decision_periods(motor: Motor) -> int:
    """PWM periods between two decisions where a schedule runs."""
    return whole_periods(RUNNING, motor)


def decision_time(motor: Motor) -> float:
    """Time between two decisions where a schedule runs [s]: whole PWM periods."""
    return decision_periods(motor) * motor.T_s

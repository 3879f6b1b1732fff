"""The shipped log, replayed once for all who look at it."""

from functools import cache

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.replay.replay import SAMPLE, Replay, load, replay


@cache
def replayed_sample() -> Replay:
    """By the default drive under Eq. 25."""
    motor, design = Motor.load("paper"), DriveDesign()
    return replay(load(SAMPLE, motor, design), motor, design, make_policy("eq25", motor))

"""Factors between SI units and those that users read and write."""

import math

RPM_TO_RAD_S = math.pi / 30.0
"""One r/min [rad/s]."""
RAD_S_TO_RPM = 30.0 / math.pi
"""One rad/s [r/min]."""


def rad_per_s(rpm: float) -> float:
    """Speed in r/min as rad/s, rounded last: numbers of a drive are made with it, to the bit."""
    return rpm * math.pi / 30.0

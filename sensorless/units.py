"""Factors between SI units and those that people read and write."""

import math

RPM_TO_RAD_S = math.pi / 30.0
"""[rad/s] of one r/min."""
RAD_S_TO_RPM = 30.0 / math.pi
"""[r/min] of one rad/s."""

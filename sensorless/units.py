"""Factors between SI units and those that users read and write."""

import math

RPM_TO_RAD_S = math.pi / 30.0
"""One r/min [rad/s]."""
RAD_S_TO_RPM = 30.0 / math.pi
"""One rad/s [r/min]."""

"""Factors between SI units and those that users read and write, and the range of angles."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

RPM_TO_RAD_S = math.pi / 30.0
"""One r/min [rad/s]."""
RAD_S_TO_RPM = 30.0 / math.pi
"""One rad/s [r/min]."""


def rad_per_s(rpm: float) -> float:
    """Speed in r/min as rad/s, rounded last: numbers of a drive are made with it, to the bit."""
    return rpm * math.pi / 30.0


def wrapped(angle: float | NDArray[np.float64]) -> Any:
    """Angles [rad] in -pi to below pi; as ``angle``, a number or an array of any shape."""
    return np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi

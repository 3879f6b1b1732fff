"""The observation: one table of its components for the environment, the exporter and the docs.

The values come from ``core/drive/signals.h``, which also runs on the target; each is a quantity
that the firmware measures or estimates, divided by a fixed scale of the machine. Quantities with a
sign count as positive in the direction of motion, so both directions of rotation look the same.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Observation = NDArray[np.float32]


@dataclass(frozen=True)
class Signal:
    """One component of the observation."""

    name: str
    unit: str
    """Unit of the quantity before it is scaled."""
    scale: str
    """What the value 1 stands for."""
    low: float
    high: float
    """Bounds of the scaled value; the environment clips to them."""
    doc: str


SIGNALS = (
    Signal("speed", "rad/s", "rated electrical speed", 0, 3,
           "magnitude of the estimated speed"),
    Signal("torque_current", "A", "rated current, peak", -4, 4,
           "measured q current; positive when motoring"),
    Signal("disagreement", "rad", "30 degrees", -3, 3,
           "angle of the injection estimator minus that of the observer; beyond a quarter turn it "
           "falls, to 0 at half a turn"),
    Signal("acceleration", "rad/s^2", "rated electrical speed in 1 s", -200, 200,
           "slope of the estimated speed"),
    Signal("speed_error", "rad/s", "rated electrical speed", -6, 6,
           "reference minus estimated speed"),
    Signal("speed_ref", "rad/s", "rated electrical speed", -3, 3,
           "speed reference"),
    Signal("k_s", "1", "all injection", 0, 1,
           "weight in force"),
    Signal("emf", "V", "magnet flux times rated speed", 0, 10,
           "magnitude of the estimated extended EMF"),
    Signal("hf_amplitude", "A", "answer of the machine without load", 0, 6,
           "magnitude of the injected current's answer; 0 while nothing is injected"),
    Signal("hfi_residual", "1", "0.5", 0, 4,
           "RMS of the injection estimator's error signal"),
    Signal("smo_residual", "1", "0.5", 0, 4,
           "RMS of the observer's error signal"),
    Signal("voltage", "V", "voltage limit", 0, 20,
           "voltage that the current controller asks for"),
)  # fmt: skip
N_SIGNALS = len(SIGNALS)

LOW: Observation = np.array([s.low for s in SIGNALS], dtype=np.float32)
HIGH: Observation = np.array([s.high for s in SIGNALS], dtype=np.float32)
LOW.setflags(write=False)
HIGH.setflags(write=False)


def bounded(signals: Observation) -> Observation:
    """Copy of ``signals`` (n, N_SIGNALS) within the bounds; NaN becomes the lower bound."""
    above: Observation = np.fmax(signals, LOW)
    return np.fmin(above, HIGH, out=above)

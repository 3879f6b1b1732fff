"""Where the voltages carry the angle without injection: the end of Eq. 25's band."""

import math

from sensorless.machine.motor import Motor
from sensorless.observers.coupled_design import damping
from sensorless.observers.flux_design import standstill_rate
from sensorless.observers.tracking import unknown_drift

UNAIDED = math.radians(15.0)
"""Most that errors of the voltage may lean the angle by without injection [rad]: a quarter of what
loses the drive, since noise, wrong inductances and half of it again in passing come on top."""


def unaided_speed(motor: Motor) -> float:
    """Electrical speed from which ``unknown_drift`` v leans the angle by ``UNAIDED`` [rad/s].

    Without injection v leaves the angle 2 (b + zeta omega) v / omega^2 behind, with b the
    ``standstill_rate`` (docs/coupled-observer.md, "Damping against lean").
    """
    v, b, zeta = unknown_drift(motor), standstill_rate(motor), damping(motor)
    return (zeta * v + math.sqrt((zeta * v) ** 2 + 2.0 * b * v * UNAIDED)) / UNAIDED

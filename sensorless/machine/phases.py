"""Quantities of three phases: their space vector, amplitude-invariant, and back.

A vector is (n, 2), alpha and beta; phases are (n, 3), a, b and c. The shipped C has its own of both
(``core/drive/frames.h``), for one period at a time.
"""

import numpy as np

from sensorless.machine.magnetics import Floats

ANGLES = 2.0 * np.pi / 3.0 * np.arange(3)
AXES = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)
"""(3, 2) directions of the phases."""


def clarke(phases: Floats) -> Floats:
    """Phases (n, 3) to their vector (n, 2); a common part is dropped."""
    return np.asarray(2.0 / 3.0 * (phases @ AXES))


def phases_of(vector: Floats) -> Floats:
    """Vector (n, 2) to the phases (n, 3) without a common part."""
    return np.asarray(vector @ AXES.T)


def with_third(i_a: Floats, i_b: Floats) -> Floats:
    """Currents (n, 3) [A] of a star from two of them (n,): the sum is zero."""
    return np.stack([i_a, i_b, -(i_a + i_b)], axis=-1)


def leg_losses(i: Floats, u_lost: float, inv_i_zero: float) -> Floats:
    """Voltages (n, 3) [V] that legs with the currents i (n, 3) [A] lose to dead time and switches.

    Odd, linear up to 1 / ``inv_i_zero`` [A], ``u_lost`` [V] beyond.
    """
    return np.asarray(u_lost * np.clip(i * inv_i_zero, -1.0, 1.0))


def duties(u: Floats, u_dc: Floats) -> Floats:
    """Duty cycles (n, 3) of the inverter for voltages (n, 2) [V] at DC-link voltages (n,) [V]."""
    phases = phases_of(u)
    middle = 0.5 * (phases.max(axis=1) + phases.min(axis=1))
    return np.asarray(np.clip(0.5 + (phases - middle[:, None]) / u_dc[:, None], 0.0, 1.0))

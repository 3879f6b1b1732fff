"""Where a corrected flux map is no longer that of a machine: its inductance has to be positive."""

import numpy as np

from sensorless.core.api import Array
from sensorless.machine.magnetics import (
    Floats,
    inverse_inductance,
    plant_currents,
    slopes,
)
from sensorless.machine.motor import Motor

STEPS = 4
"""Points a cell of the correction's grid."""
LEAST = 0.02
"""Least slope of current over flux that counts as positive, over 1 / L_q."""


def fold(motor: Motor) -> Floats | None:
    """Current (i_d, i_q) [A] at which the simulated machine has no inductance; None: nowhere.

    Looked at are all flux linkages of the correction that take at most ``i_trip``, beyond which a
    drive is lost. Where the saturation model alone has none either, nothing is said.
    """
    if motor.flux_correction is None:
        return None
    psi = _grid(motor.flux_correction.record)
    i = plant_currents(motor, psi)
    near = np.hypot(*i.T) <= motor.i_trip
    psi, i = psi[near], i[near]
    step = 1e-6 * float(np.abs(psi).max(initial=1e-6))
    least = LEAST / motor.L_q
    own = _lowest(inverse_inductance(motor.saturation, psi, step))
    bad = (_lowest(slopes(lambda at: plant_currents(motor, at), psi, step)) <= least) & (
        own > least
    )
    if not bad.any():
        return None
    return np.asarray(i[bad][np.argmin(np.hypot(*i[bad].T))])


def _grid(record: Array) -> Floats:
    n_d, n_q = (STEPS * int(record[name]) + 1 for name in ("n_d", "n_q"))
    d = record["psi_d0"] + np.arange(n_d) / (STEPS * record["inv_h_d"])
    q = np.arange(n_q) / (STEPS * record["inv_h_q"])
    return np.stack(np.meshgrid(d, q, indexing="ij"), axis=-1).reshape(-1, 2)


def _lowest(gamma: Floats) -> Floats:
    return np.asarray(np.linalg.eigvalsh(0.5 * (gamma + gamma.swapaxes(1, 2)))[:, 0])

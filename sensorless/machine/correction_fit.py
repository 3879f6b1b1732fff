"""Fit of a correction to what the saturation model leaves of a flux map.

The currents of a correction are linear in its coefficients: least squares on the current that is
left at the map's flux linkages, with a small weight on the slopes' size, which lets the correction
fade where the map has no points. The core itself gives the columns of the matrix.
"""

import dataclasses
from itertools import product

import numpy as np

from sensorless.core.api import Array
from sensorless.core.machine import flux_correction_currents
from sensorless.errors import UserError
from sensorless.machine.flux_correction import FluxCorrection, rounded
from sensorless.machine.folds import fold
from sensorless.machine.magnetics import Floats, currents, plant_currents
from sensorless.machine.map_fit import OUTSIDE
from sensorless.machine.motor import Motor

GRIDS = ((12, 8), (16, 9), (20, 10))
"""Numbers of coefficients along psi_d and psi_q, coarse to fine."""
ENOUGH = 0.5
"""RMS error within rated current at which no finer grid is tried [% of rated current]."""
MARGINS = (0.25, 0.5)
"""How far the grid reaches beyond the map's flux linkages, over their range: there it fades."""
SMOOTH = (6e-4, 2e-3)
"""Weight of a slope over the range of psi_d, against the RMS error of the current."""
MOST = 4000
"""Points of a map that are used; of a larger one, so many at random."""


def corrected(motor: Motor, i: Floats, psi: Floats) -> Motor:
    """The machine with a correction that follows a map within ``i_max``.

    Parameters
    ----------
    motor : Motor
        With the saturation model that was fitted to the map.
    i, psi : arrays, shape (n, 2)
        The map's currents [A] and flux linkages [Vs].

    Raises
    ------
    UserError
        Somewhere within the map the machine would have no inductance.
    """
    use = np.flatnonzero(np.hypot(*i.T) <= (1.0 + 1e-9) * motor.i_max)
    if len(use) > MOST:
        use = np.sort(np.random.default_rng(0).choice(use, MOST, replace=False))
    i, psi = i[use], psi[use]
    left = i - currents(motor.saturation, psi)
    rated = np.hypot(*i.T) <= motor.i_rated
    weight = np.where(rated, 1.0, OUTSIDE) / np.sqrt(len(i))
    best: tuple[float, Motor] | None = None
    for smooth, grid, margin in product(SMOOTH, GRIDS, MARGINS):
        made = dataclasses.replace(
            motor, flux_correction=_fit(psi, left, weight, grid, margin, smooth)
        )
        at = fold(made)
        if at is not None:
            continue
        error = plant_currents(made, psi[rated]) - i[rated]
        rms = 100.0 * float(np.sqrt(np.mean(error**2, axis=0)).max()) / motor.i_rated
        if best is None or rms < best[0]:
            best = rms, made
        if rms <= ENOUGH:
            break
    if best is None:
        assert at is not None
        raise UserError(
            f"map: current does not rise with flux near i_d = {at[0]:.3g} A, i_q = {at[1]:.3g} "
            "A, as it does in a machine; smooth the map there, or lower i_max"
        )
    return best[1]


def _fit(
    psi: Floats,
    left: Floats,
    weight: Floats,
    grid: tuple[int, int],
    margin: float,
    smooth: float,
) -> FluxCorrection:
    """Correction of a grid to the currents (n, 2) left at flux linkages (n, 2)."""
    low, high = psi[:, 0].min(), psi[:, 0].max()
    edge = margin * (high - low)
    box = {
        "psi_d_from": float(f"{low - edge:.6g}"),
        "psi_d_to": float(f"{high + edge:.6g}"),
        "psi_q_to": float(f"{(1.0 + margin) * np.abs(psi[:, 1]).max():.6g}"),
    }
    n = grid[0] * grid[1]
    units = [
        FluxCorrection(**box, energy=tuple(map(tuple, unit))).record
        for unit in np.eye(n).reshape(n, *grid)
    ]
    bend = smooth * (high - low) * _slopes(units[0], *grid)
    columns = np.stack([flux_correction_currents(unit, psi) for unit in units], axis=-1)
    rows = (weight[:, None, None] * columns).reshape(-1, n)
    wanted = rows.T @ (weight[:, None] * left).reshape(-1)
    c = np.linalg.solve(rows.T @ rows + bend.T @ bend, wanted).reshape(grid)
    return rounded(FluxCorrection(**box, energy=tuple(map(tuple, c.tolist()))))


def _slopes(record: Array, n_d: int, n_q: int) -> Floats:
    """Rows whose products with the coefficients are about d2W/dpsi_d2 and d2W/dpsi_q2."""
    d, q = np.eye(n_d), np.eye(n_q)
    none_d, none_q = np.zeros((2, n_d)), np.zeros((2, n_q))
    bend_d = np.diff(np.concatenate([none_d, d, none_d]), 2, axis=0) * record["inv_h_d"] ** 2
    bend_q = np.diff(np.concatenate([q[1:2], q, none_q]), 2, axis=0) * record["inv_h_q"] ** 2
    return np.concatenate([np.kron(bend_d, q), np.kron(d, bend_q)])

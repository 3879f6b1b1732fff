"""Runs the machine alone: ``sensorless simulate --plant --inputs --out``."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sensorless.core.api import PLANT, PLANT_NAMES, PLANT_STATE, Array
from sensorless.core.machine import plant_run
from sensorless.design.records import SUB_STEPS
from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.machine.magnetics import Floats, extra_terms, flux, flux_map_record
from sensorless.machine.phases import phases_of
from sensorless.plant.case import PlantCase, read_case
from sensorless.plant.inputs import read_inputs

COLUMNS = (
    "t",
    "i_d",
    "i_q",
    "i_alpha",
    "i_beta",
    "i_a",
    "i_b",
    "i_c",
    "psi_d",
    "psi_q",
    "tau_M",
    "w_M",
    "theta_m",
)
"""Names of the file's format: in it M is mechanical and m electrical, so w_M is the speed of the
shaft and theta_m the electrical angle."""
THETA_E = PLANT_NAMES.index("theta_e")
STEP_ERROR = 1e-8
"""Largest accepted difference to a run with twice the step [A, rad, ...]."""
WORST = 1e-5
"""Largest difference at ``SPLITS`` that is no error, beside that share of the column's largest."""
SPLITS = 256
"""Most pieces that a period is cut into, each of ``SUB_STEPS`` Runge-Kutta steps."""
CHUNK = 2**17


@dataclass(frozen=True)
class PlantRun:
    """Result of a run."""

    rows: Floats
    """shape (n + 1, 13), ``COLUMNS`` at every sampling instant"""
    sub_steps: int
    """Runge-Kutta steps per period"""
    step_error: float
    """largest difference to the run with twice the step"""


def plant_arrays(
    case: PlantCase, sub_steps: int = SUB_STEPS, split: int = 1
) -> tuple[Array, Array]:
    """Records of PLANT and PLANT_STATE, shape (1,), at the start of a case.

    Parameters
    ----------
    sub_steps : int
        Runge-Kutta steps per piece of a period.
    split : int
        Pieces that a period is cut into.
    """
    plant = np.zeros(1, dtype=PLANT)
    plant["map"] = flux_map_record(case.saturation)
    plant["R_s"], plant["n_p"], plant["B"] = case.R_s, case.n_p, case.B
    plant["inv_J"] = 1.0 / case.J
    plant["n_sub"], plant["h"] = sub_steps, case.T_s / (sub_steps * split)
    plant["extra"] = extra_terms(case.saturation)
    state = np.zeros(1, dtype=PLANT_STATE)
    psi = flux(case.saturation, np.array([[case.i_d, case.i_q]]))[0]
    state["psi_d"], state["psi_q"] = psi
    state["omega_m"] = case.omega_m
    state["theta_e"] = math.remainder(case.theta_e, 2.0 * math.pi)
    return plant, state


def integrate(case: PlantCase, inputs: Floats, split: int = 1) -> Floats:
    """Run a case with every period cut into ``split`` pieces.

    Returns
    -------
    array, shape (n + 1, len(PLANT_NAMES))
        Currents [A], flux [Vs], torque [N m], mechanical speed [rad/s], electrical angle in
        [-pi, pi] [rad].
    """
    plant, state = plant_arrays(case, split=split)
    parts = []
    block = max(1, CHUNK // split)
    for start in range(0, len(inputs), block):
        held = np.repeat(inputs[start : start + block], split, axis=0)
        out = plant_run(plant, state, held)[::split]
        parts.append(out if start == 0 else out[1:])
    rows = np.concatenate(parts)
    angle = rows[:, THETA_E]
    angle[:] = np.arctan2(np.sin(angle), np.cos(angle))
    return rows


def run_case(case: PlantCase, inputs: Floats) -> PlantRun:
    """Run a case, halving the step until the change is within ``STEP_ERROR``.

    The first step is that of the closed loop.

    Raises
    ------
    UserError
        The machine runs away under these voltages, or ``SPLITS`` pieces a period are too few.
    """
    split = 1
    with np.errstate(over="ignore", invalid="ignore"):
        coarse = integrate(case, inputs, split)
        while True:
            split *= 2
            fine = integrate(case, inputs, split)
            gap = np.abs(fine - coarse)
            gap[:, THETA_E] = np.abs(np.sin(fine[:, THETA_E] - coarse[:, THETA_E]))
            allowed = STEP_ERROR + 0.01 * STEP_ERROR * np.max(np.abs(fine), axis=0)
            if np.all(gap <= allowed) or split >= SPLITS:
                break
            coarse = fine
    bad = np.flatnonzero(~np.isfinite(fine).all(axis=1))
    if bad.size:
        raise UserError(
            f"plant: no finite state from t = {bad[0] * case.T_s:g} s on; check the machine and "
            "the voltages, or give a T_s that is short against its dynamics"
        )
    far = np.argwhere(gap > WORST + WORST * np.max(np.abs(fine), axis=0))
    if far.size:
        row, column = far[0]
        raise UserError(
            f"plant: {PLANT_NAMES[column]} at t = {row * case.T_s:g} s changes by "
            f"{gap[row, column]:.2g} with half the step, at {SUB_STEPS * split} steps a period; "
            f"T_s = {case.T_s:g} s is too long for these dynamics: give more and shorter periods"
        )
    return PlantRun(_columns(fine, case.T_s), SUB_STEPS * split, float(np.max(gap)))


def _columns(rows: Floats, T_s: float) -> Floats:
    """``COLUMNS`` from the rows of ``integrate``."""
    i_d, i_q, psi_d, psi_q, tau, omega_m, theta_e = rows.T
    c, s = np.cos(theta_e), np.sin(theta_e)
    i_alpha, i_beta = c * i_d - s * i_q, s * i_d + c * i_q
    return np.stack(
        [
            T_s * np.arange(len(rows)),
            i_d,
            i_q,
            i_alpha,
            i_beta,
            *phases_of(np.stack([i_alpha, i_beta], axis=-1)).T,
            psi_d,
            psi_q,
            tau,
            omega_m,
            theta_e,
        ],
        axis=-1,
    )


def to_csv(rows: Floats) -> str:
    """Text of a table of ``COLUMNS``, 13 significant digits."""
    form = ",".join(["%.13g"] * len(COLUMNS)) + "\n"
    return ",".join(COLUMNS) + "\n" + "".join(form % tuple(row) for row in rows.tolist())


def simulate_plant(plant: str | Path, inputs: str | Path, out: str | Path) -> PlantRun:
    """Read a machine and its inputs, run it and write the trajectory.

    Parameters
    ----------
    plant : path
        JSON as for ``sensorless.plant.case.read_case``.
    inputs : path
        CSV as for ``sensorless.plant.inputs.read_inputs``.
    out : path
        CSV to write, one row per sampling instant; it appears whole or not at all.

    Raises
    ------
    UserError
        A file is wrong, or the machine runs away.
    """
    case = read_case(plant)
    run = run_case(case, read_inputs(inputs))
    write_atomic(out, to_csv(run.rows))
    return run

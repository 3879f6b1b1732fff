"""The machine without its drive, in the compiled core."""

import zlib

import numpy as np

from sensorless.core.api import (
    CARRIER_NAMES,
    PIECES_A_PERIOD,
    PLANT_NAMES,
    Array,
    enumeration,
    lib,
    pointer,
    struct_dtype,
)
from sensorless.errors import UserError

COMMAND = struct_dtype("command_t")
CORRECTION = struct_dtype("flux_correction_t")
SLOPE = struct_dtype("plant_slope_t")
COMMISSION_NAMES = tuple(enumeration("COMMISSION_"))

_ENTERED: dict[int, Array] = {}
"""Records that the core reads for as long as the process lives, by key."""


def flux_map_currents(flux_map: Array, extra: int, psi: Array) -> Array:
    """Currents (n, 2) [A] at flux linkages ``psi`` (n, 2) [Vs] of a FLUX_MAP record.

    ``extra``: EXTRA_* of ``core/sim/flux_map.h``, what the map has beyond saturation.
    """
    points = np.ascontiguousarray(psi, dtype=np.float64)
    out = np.empty_like(points)
    lib.flux_map_currents(
        pointer(flux_map.reshape(1), "flux_map_t[]"),
        extra,
        pointer(points, "double[]"),
        pointer(out, "double[]"),
        len(points),
    )
    return out


def flux_correction_currents(correction: Array, psi: Array) -> Array:
    """Currents (n, 2) [A] at flux linkages ``psi`` (n, 2) [Vs] of a CORRECTION record."""
    points = np.ascontiguousarray(psi, dtype=np.float64)
    out = np.empty_like(points)
    lib.flux_correction_currents(
        pointer(correction.reshape(1), "flux_correction_t[]"),
        pointer(points, "double[]"),
        pointer(out, "double[]"),
        len(points),
    )
    return out


def edge_losses(slope: Array, u: Array, i: Array, u_dc: Array, u_lost: float, T_s: float) -> Array:
    """Voltages (n, 2) [V] that dead time takes in n periods, from the currents at its edges.

    Parameters
    ----------
    slope : (n,) array of SLOPE
        Of the current in each period.
    u, i : (n, 2)
        Commands [V], and currents at the starts of the periods [A], stator frame.
    u_dc : (n,)
        DC link [V].
    u_lost : float
        Voltage that a leg loses once its current is large [V].
    T_s : float
        Period [s].
    """
    u, i, u_dc = (np.ascontiguousarray(x, dtype=np.float32) for x in (u, i, u_dc))
    lost = np.empty_like(u)
    lib.edge_losses(
        pointer(slope, "plant_slope_t[]"),
        pointer(u, "ab_t[]"),
        pointer(i, "ab_t[]"),
        pointer(u_dc, "float[]"),
        u_lost,
        T_s,
        len(u),
        pointer(lost, "ab_t[]"),
    )
    return lost


def enter_correction(correction: Array) -> int:
    """Let flux maps name a CORRECTION record; returns its key, which follows from its numbers.

    Raises
    ------
    UserError
        Another one of this process has its place.
    """
    record = correction.reshape(1).copy()
    record["key"] = 0
    key = zlib.crc32(record.tobytes()) or 1
    if key not in _ENTERED:
        record["key"] = key
        if not lib.flux_correction_enter(pointer(record, "flux_correction_t[]")):
            raise UserError(
                "flux_correction: its key clashes with that of another machine of this process; "
                "simulate the two in separate ones"
            )
        _ENTERED[key] = record
    return key


def plant_run(plant: Array, state: Array, u: Array) -> Array:
    """Run the machine alone.

    Parameters
    ----------
    plant, state : records of PLANT and PLANT_STATE, shape (1,)
        ``state`` is changed in place and must hold flux, speed and angle.
    u : array, shape (n, 3)
        Stator voltage alpha, beta [V] and load torque [N m], each held for one period.

    Returns
    -------
    array, shape (n + 1, len(PLANT_NAMES))
        Currents [A], flux [Vs], torque [N m], omega_m [rad/s], theta_e unwrapped [rad].
    """
    inputs = np.ascontiguousarray(u, dtype=np.float64)
    out = np.empty((len(inputs) + 1, len(PLANT_NAMES)))
    p, x = pointer(plant, "plant_params_t[]"), pointer(state, "plant_state_t[]")
    lib.plant_start(p, x)
    lib.plant_run(p, x, pointer(inputs, "double[]"), pointer(out, "double[]"), len(inputs))
    return out


def carrier_run(sensor: Array, plant: Array, state: Array, u: Array) -> Array:
    """Run the machine alone on a switching inverter, and record it between the edges.

    Parameters
    ----------
    sensor, plant, state : records of SENSOR, PLANT and PLANT_STATE, shape (1,)
        ``state`` is changed in place and must hold flux, speed and angle.
    u : array, shape (n, 4)
        Stator voltage alpha, beta and DC link [V] and load torque [N m], each for one period.

    Returns
    -------
    array, shape (rows, len(CARRIER_NAMES))
        One row per Runge-Kutta step, ``n_sub`` steps from edge to edge, and one for the end; the
        voltage of a row acts until the next row.
    """
    inputs = np.ascontiguousarray(u, dtype=np.float64)
    most = len(inputs) * PIECES_A_PERIOD * int(plant["n_sub"][0]) + 1
    out = np.empty((most, len(CARRIER_NAMES)))
    p, x = pointer(plant, "plant_params_t[]"), pointer(state, "plant_state_t[]")
    lib.plant_start(p, x)
    n = lib.carrier_run(
        pointer(sensor, "sensor_params_t[]"),
        p,
        x,
        pointer(inputs, "double[]"),
        pointer(out, "double[]"),
        len(inputs),
    )
    return out[:n]


def commission_run(sim: Array, commands: Array, i_stop: float) -> Array:
    """Run test commands of ``core/sim/commission.h`` on one drive, shape (1,), changed in place.

    Parameters
    ----------
    commands : array of COMMAND, shape (n,)
    i_stop : float
        Measured current at which the run stops [A].

    Returns
    -------
    array, shape (rows, len(COMMISSION_NAMES))
        One row per PWM period.
    """
    out = np.empty((int(commands["n"].sum()), len(COMMISSION_NAMES)))
    rows = lib.commission_run(
        pointer(sim, "sim_t[]"),
        pointer(commands, "command_t[]"),
        len(commands),
        i_stop,
        pointer(out, "double[]"),
    )
    return out[:rows]

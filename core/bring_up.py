"""The check of a drive's installation (``core/drive/bring_up.h``) in NumPy terms."""

import numpy as np

from sensorless.core.api import Array, enumeration, lib, pointer, struct_dtype

PARAMS = struct_dtype("bring_up_params_t")
STATE = struct_dtype("bring_up_state_t")
BUILT = struct_dtype("built_t")
FAULTS = enumeration("BRING_UP_FAULT_")
"""Bits of ``bring_up_state_t.fault`` by name."""
WIRINGS = tuple(enumeration("WIRING_"))
BUILT_NAMES = tuple(enumeration("BUILT_"))


def pulse_times(params: Array) -> tuple[int, int, int]:
    """PWM periods before the pulses along d, of one cycle of them, and of all cycles."""
    p = params.reshape(-1)[0]
    cycle = 2 * (int(p["n_push"]) + int(p["n_hold"])) + int(p["n_gap"])
    before = int(p["n_rest"]) + int(p["n_probe"]) * int(p["n_gap"])
    return before, cycle, int(p["n_cycles"]) * cycle


def periods_of(params: Array) -> int:
    """PWM periods that the check takes, and some more."""
    before, _, pulses = pulse_times(params)
    return before + pulses + 1


def _begin() -> tuple[Array, object]:
    state = np.zeros(1, dtype=STATE)
    pointed = pointer(state, "bring_up_state_t[]")
    lib.bring_up_init(pointed)
    return state, pointed


def bring_up_run(sim: Array, built: Array, params: Array) -> tuple[Array, Array]:
    """Run the check on one simulated drive, shape (1,), changed in place.

    Parameters
    ----------
    built : array of BUILT, shape (1,)
        How the drive is built in.
    params : array of PARAMS, shape (1,)

    Returns
    -------
    record of STATE
        At the end.
    array, shape (rows, len(BUILT_NAMES))
        One row per PWM period: the samples that the core got and the voltages that it returned.
    """
    state, x = _begin()
    n = periods_of(params)
    out = np.zeros((n, len(BUILT_NAMES)))
    rows = lib.bring_up_run(
        pointer(sim, "sim_t[]"),
        pointer(built, "built_t[]"),
        pointer(params, "bring_up_params_t[]"),
        x,
        n,
        pointer(out, "double[]"),
    )
    return state[0], out[:rows]


def bring_up_replay(params: Array, i_a: Array, i_b: Array) -> tuple[Array, int]:
    """Run the check on logged samples (n,) [A]; returns its state and the rows that it took."""
    state, x = _begin()
    rows = np.zeros((len(i_a), len(BUILT_NAMES)))
    rows[:, BUILT_NAMES.index("i_a")], rows[:, BUILT_NAMES.index("i_b")] = i_a, i_b
    p = pointer(params, "bring_up_params_t[]")
    used = lib.bring_up_replay(p, x, len(rows), pointer(rows, "double[]"))
    return state[0], int(used)

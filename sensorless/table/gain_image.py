"""Gains as the firmware holds them: a header ``gain_table_t`` and stored node values.

Checksums, check and lookup run the code of ``core/drive/gain_table.c``.
"""

from collections.abc import Sequence

import numpy as np

from sensorless.core.api import SIGNAL_N, Array, lib, pointer, struct_dtype
from sensorless.core.gains import GAIN_N, GAIN_NAMES, Values
from sensorless.table.gain_grid import GainGrid
from sensorless.table.image import flat_values

GAIN_TABLE = struct_dtype("gain_table_t")


def stored(grids: Sequence[GainGrid], form: str) -> Array:
    """Node values of all grids as the firmware stores them: flat, float32 or int16 (Q15)."""
    return flat_values(np.concatenate([g.values.reshape(-1) for g in grids]), form)


def record(grids: Sequence[GainGrid], axes: Array, form: str, decision: float) -> Array:
    """Header ``gain_table_t`` with its checksums, shape (1,).

    Parameters
    ----------
    grids : sequence of GainGrid
        In the order of ``GAIN_NAMES``.
    axes : record of ks_table_t, shape (1,)
        The k_s table that the grids belong to, of the same ``form``.
    form : {"f32", "q15"}
    decision : float
        Time from one decision to the next [s].
    """
    header = np.zeros(1, dtype=GAIN_TABLE)
    header["magic"], header["format"] = lib.GAINS_MAGIC, lib.GAINS_FORMAT
    header["n_gains"], header["n_nodes"] = len(grids), axes["n_nodes"]
    for j, grid in enumerate(grids):
        header["gain"][0, j] = GAIN_NAMES.index(grid.gain)
        for name, x in grid.range.limits(decision).items():
            header["limit"][0, j][name] = x
    header["crc_table"] = axes["crc_header"]
    values = stored(grids, form)
    t, k = pointer(header, "gain_table_t[]"), pointer(axes, "ks_table_t[]")
    header["crc_values"] = lib.gain_values_crc(t, k, pointer(values, "char[]"))
    header["crc_header"] = lib.gain_header_crc(t)
    return header


def check(header: Array, axes: Array, values: Array) -> int:
    """Return 0 if header and values are good, else a key of ``image.PROBLEMS``."""
    t, k = pointer(header, "gain_table_t[]"), pointer(axes, "ks_table_t[]")
    return int(lib.gain_table_check(t, k, pointer(values, "char[]")))


def lookup(header: Array, axes: Array, values: Array, obs: Array) -> Values:
    """Values (n, GAIN_N) at contiguous signals (n, SIGNAL_N); all have passed ``check``."""
    out = np.empty((len(obs), GAIN_N), dtype=np.float32)
    if len(obs):
        lib.gain_table_eval_many(
            pointer(header, "gain_table_t[]"),
            pointer(axes, "ks_table_t[]"),
            pointer(values, "char[]"),
            pointer(obs, "float[]"),
            pointer(out, "float[]"),
            len(obs),
            SIGNAL_N,
        )
    return out

"""The table as the firmware holds it: a header ``ks_table_t`` and stored node values.

Checksums, check and lookup run the code of ``core/drive/ks_table.c``.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, Array, lib, pointer
from sensorless.errors import UserError

PROBLEMS: dict[int, str] = {
    lib.KS_BAD_MAGIC: "not a table",
    lib.KS_BAD_FORMAT: "unknown format number",
    lib.KS_BAD_CRC: "wrong CRC",
    lib.KS_BAD_AXES: "axis out of range",
    lib.KS_BAD_VALUE: "value out of range",
    lib.KS_BAD_MOTOR: "made for another motor",
}
"""What each result of ``check`` means; 0 is a good table."""


def flat_values(values: NDArray[np.float32], form: str) -> Array:
    """Return node values as the firmware stores them: flat, float32 or int16 (Q15).

    Raises
    ------
    UserError
        ``form`` is neither.
    """
    if form not in ("f32", "q15"):
        raise UserError(f"table: form: {form!r}; give 'f32' or 'q15'")
    flat = values.reshape(-1)
    if form == "f32":
        return flat
    return np.rint(flat.astype(np.float64) * 32767.0).astype(np.int16)


def seal(header: Array, values: Array) -> None:
    """Write both checksums into a header of shape (1,) whose other fields are final."""
    t = pointer(header, "ks_table_t[]")
    header["crc_values"] = lib.ks_values_crc(t, pointer(values, "char[]"))
    header["crc_header"] = lib.ks_header_crc(t)


def check(header: Array, values: Array, motor_hash: int = 0) -> int:
    """Return 0 if a header of shape (1,) and its values are good, else a key of ``PROBLEMS``."""
    t = pointer(header, "ks_table_t[]")
    return int(lib.ks_table_check(t, pointer(values, "char[]"), motor_hash))


def lookup(header: Array, values: Array, obs: NDArray[np.float32]) -> NDArray[np.float32]:
    """k_s (n,) at contiguous signals (n, SIGNAL_N); header and values have passed ``check``."""
    return bound(header, values)(obs)


def bound(header: Array, values: Array) -> Callable[[NDArray[np.float32]], NDArray[np.float32]]:
    """`lookup` in one table, again and again."""
    table, nodes = pointer(header, "ks_table_t[]"), pointer(values, "char[]")

    def at(obs: NDArray[np.float32]) -> NDArray[np.float32]:
        n = len(obs)
        out = np.empty(n, dtype=np.float32)
        if n:
            there, into = pointer(obs, "float[]"), pointer(out, "float[]")
            lib.ks_table_eval_many(table, nodes, there, into, n, SIGNAL_N)
        return out

    return at

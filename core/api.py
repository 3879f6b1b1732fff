"""The compiled core in NumPy terms: structured dtypes of its C structs, and its functions.

A drive, its machine and its sensored twin are one record of ``SIM``. An array of them is a plain
NumPy array, which NumPy copies, pickles and slices.
"""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.errors import StaleCoreError, UserError

try:
    from sensorless import _core  # type: ignore[attr-defined]
except ImportError as error:
    raise StaleCoreError(
        f"the compiled core cannot be imported ({error}): build it with 'make core' in a checkout, "
        "or reinstall the package"
    ) from None

ffi = _core.ffi
lib = _core.lib

Array = NDArray[Any]


def _check_fresh() -> None:
    """In a checkout, refuse a core that was built from other sources."""
    if not (Path(__file__).resolve().parent / "sim" / "simulate.c").exists():
        return
    from sensorless.core.source_hash import source_hash

    built = ffi.string(lib.core_hash).decode()
    if built != source_hash():
        raise StaleCoreError("the compiled core is older than core/*/*.[ch]: run 'make core'")


_check_fresh()

_KINDS = {
    "float": np.float32,
    "double": np.float64,
    "int": np.int32,
    "int32_t": np.int32,
    "uint32_t": np.uint32,
}


def _dtype_of(ctype: Any) -> np.dtype[Any]:
    """NumPy dtype with the layout of a C type: numbers, arrays and structs of them."""
    if ctype.kind == "array":
        return np.dtype((_dtype_of(ctype.item), (ctype.length,)))
    if ctype.kind != "struct":
        return np.dtype(_KINDS[ctype.cname])
    fields = ctype.fields
    return np.dtype(
        {
            "names": [name for name, _ in fields],
            "formats": [_dtype_of(field.type) for _, field in fields],
            "offsets": [field.offset for _, field in fields],
            "itemsize": ffi.sizeof(ctype),
        }
    )


def struct_dtype(name: str) -> np.dtype[Any]:
    """NumPy dtype of the C struct ``name``, e.g. ``"drive_params_t"``."""
    return _dtype_of(ffi.typeof(name))


SIM = struct_dtype("sim_t")
CONTROL = struct_dtype("drive_params_t")
SENSOR = struct_dtype("sensor_params_t")
PLANT = struct_dtype("plant_params_t")
PLANT_STATE = struct_dtype("plant_state_t")
FLUX_MAP = struct_dtype("flux_map_t")
GAINS = struct_dtype("sim_gains_t")
TABLE = struct_dtype("ks_table_t")
REPLAY_IN = struct_dtype("replay_in_t")

_SUMS_AT = ffi.offsetof("sim_t", "sums")

SIGNAL_N: int = lib.SIGNAL_N
PROFILE_N: int = lib.PROFILE_N
CURVE_N: int = lib.CURVE_N


def enumeration(prefix: str) -> dict[str, int]:
    """Constants of the core's enumeration ``prefix``, in ascending order.

    Keys are lower-case names without the prefix. PREFIX_N, the number of constants, is left out.
    """
    names = (n for n in dir(lib) if n.startswith(prefix) and n != f"{prefix}N")
    found = {n[len(prefix) :].lower(): int(getattr(lib, n)) for n in names}
    return dict(sorted(found.items(), key=lambda item: item[1]))


TRACE_NAMES = tuple(enumeration("TRACE_"))
PLANT_NAMES = tuple(enumeration("PLANT_"))
CARRIER_NAMES = tuple(enumeration("CARRIER_"))
REPLAY_NAMES = tuple(enumeration("REPLAY_"))
PIECES_A_PERIOD: int = lib.PIECES_A_PERIOD
SIGNAL_NAMES = tuple(enumeration("SIGNAL_"))
TRUTH_NAMES = tuple(enumeration("TRUTH_"))


def pointer(array: Array, ctype: str) -> Any:
    """C pointer ``ctype`` to the start of a contiguous array."""
    return ffi.from_buffer(ctype, array)


THREADS = "SENSORLESS_THREADS"
"""Environment variable with the most threads a call may use. Default: one per processor core."""

SMALL = 10_000
"""Total periods of all drives below which one thread is faster than two."""


def threads_allowed() -> int:
    """Threads that a call may use: ``SENSORLESS_THREADS``, else the cores open to this process.

    Raises
    ------
    UserError
        The variable is not a whole number above 0.
    """
    value = os.environ.get(THREADS, "")
    if not value:
        open_to_us = getattr(os, "sched_getaffinity", None)  # not on every system
        return len(open_to_us(0)) if open_to_us else os.cpu_count() or 1
    if not (value.isascii() and value.isdigit() and int(value) > 0):
        raise UserError(f"{THREADS}: {value!r} is not a number of threads; set 1 or more")
    return min(int(value), 2**31 - 1)


def sim_run(
    sims: Array,
    periods: int,
    k_s: Array,
    obs: Array,
    gains: Array | None = None,
    *,
    plain: bool = False,
    simd: int = lib.SIMD_AVX512,
    threads: int | None = None,
) -> None:
    """Advance every drive by up to ``periods`` periods; other Python threads can run meanwhile.

    The results do not depend on ``plain``, ``simd`` or ``threads``, nor on the other drives.

    Parameters
    ----------
    sims : array of SIM, shape (n,)
        Changed in place; ``sims["sums"]`` holds the sums over this call.
    periods : int
    k_s : array of float32, shape (n,)
        Weight wanted, 0 to 1.
    obs : array of float32, shape (n, SIGNAL_N)
        Filled with each drive's signals.
    gains : array of GAINS, shape (n,), optional
        Gains to change besides k_s, one a period from the second on; changed in place.
    plain : bool
        Run drive by drive instead of in blocks of vector code.
    simd : int
        Widest vector code that blocks may use, ``lib.SIMD_AVX2`` or ``lib.SIMD_AVX512``, if the
        processor has it.
    threads : int, optional
        Most threads to use; by default `threads_allowed`, or one if the call is too small for more.
    """
    if threads is None:
        threads = threads_allowed() if len(sims) * periods >= SMALL else 1
    lib.sim_run(
        pointer(sims, "sim_t[]"),
        len(sims),
        periods,
        lib.SIMD_NONE if plain else simd,
        threads,
        pointer(k_s, "float[]"),
        ffi.NULL if gains is None else pointer(gains, "sim_gains_t[]"),
        pointer(obs, "float[]"),
    )


def sim_set_due(sims: Array, gains: Array, period: int, periods: int) -> None:
    """Bring the gains into force that come before a period of a decision; no drive moves.

    One comes before each period but the first, in the order of the records; the last period takes
    all that are left.

    Parameters
    ----------
    sims, gains : array of SIM and of GAINS, shape (n,)
    period, periods : int
        The period, counted from 0, of the decision's ``periods``.
    """
    lib.sim_set_due(
        pointer(sims, "sim_t[]"), pointer(gains, "sim_gains_t[]"), len(sims), period, periods
    )


def sim_signals(sims: Array, obs: Array) -> None:
    """Read every drive's signals into ``obs`` (n, SIGNAL_N), float32; no drive moves."""
    lib.sim_signals(pointer(sims, "sim_t[]"), len(sims), pointer(obs, "float[]"))


def sums_matrix(sims: Array) -> Array:
    """View of ``sims["sums"]`` as numbers (n, fields), which NumPy copies faster than records."""
    shape = (len(sims), SIM["sums"].itemsize // 4)
    return np.ndarray(shape, np.float32, sims, _SUMS_AT, strides=(SIM.itemsize, 4))


def sim_truth(sims: Array, u_dc: float, scale: Array, bound: float, out: Array) -> None:
    """Fill the first columns of ``out`` (n, at least TRUTH_N) with what a critic may see.

    Parameters
    ----------
    sims : array of SIM, shape (n,)
        Drives after a `sim_run`, over which the quantities are means.
    u_dc : float
        Nominal DC-link voltage [V].
    scale : array of float32, shape (TRUTH_N,)
        Factors on the quantities TRUTH_* of ``core/sim/truth.h``.
    bound : float
        Limit on the magnitude of each product; NaN becomes minus the bound.
    out : array of float32, shape (n, at least TRUTH_N)
    """
    lib.sim_truth(
        pointer(sims, "sim_t[]"),
        len(sims),
        u_dc,
        pointer(scale, "float[]"),
        bound,
        pointer(out, "float[]"),
        out.shape[1],
    )


def words(sims: Array) -> Array:
    """View of an array of SIM as plain words (n, size), which NumPy copies faster than records."""
    return sims.view(np.uint64).reshape(len(sims), -1)


def sim_start(sims: Array) -> None:
    """Put every drive at the start that its field ``start`` describes."""
    lib.sim_start(pointer(sims, "sim_t[]"), len(sims))


def sim_trace(sim: Array, periods: int, k_s: float) -> Array:
    """Advance one drive, shape (1,), and return one row of ``TRACE_NAMES`` per period.

    ``sim["sums"]`` holds the sums over this call, as after `sim_run`.
    """
    out = np.zeros((periods, len(TRACE_NAMES)))
    n = lib.sim_trace(pointer(sim, "sim_t[]"), periods, k_s, pointer(out, "double[]"))
    return out[:n]


class ObserverRun:
    """Both estimators and their blend over a recorded log; see ``core/sim/replay.h``.

    Parameters
    ----------
    control : record of CONTROL, shape ()
    theta, omega : float
        Angle and speed that both start from, electrical [rad, rad/s].
    k_s : float
        Weight to start with.
    """

    def __init__(self, control: Array, theta: float, omega: float, k_s: float) -> None:
        self._control = control.reshape(1).copy()
        self._state = np.zeros(1, dtype=struct_dtype("replay_t"))
        lib.replay_init(*self._pointers(), theta, omega, k_s)

    def _pointers(self) -> tuple[Any, Any]:
        control = pointer(self._control, "drive_params_t[]")
        return control, pointer(self._state, "replay_t[]")

    def advance(self, rows: Array, k_s: float) -> tuple[Array, Array]:
        """Process ``rows`` of REPLAY_IN under one weight.

        Returns
        -------
        array of float32, shape (n, len(REPLAY_NAMES))
        array of float32, shape (SIGNAL_N,)
            Signals after the last row.
        """
        out = np.empty((len(rows), len(REPLAY_NAMES)), dtype=np.float32)
        obs = np.empty(SIGNAL_N, dtype=np.float32)
        inputs = pointer(np.ascontiguousarray(rows), "replay_in_t[]")
        into, signals = pointer(out, "float[]"), pointer(obs, "float[]")
        lib.replay_run(*self._pointers(), inputs, len(rows), k_s, into, signals)
        return out, obs

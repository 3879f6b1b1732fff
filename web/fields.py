"""Where numbers lie in the core's records, for a page that has no copy of a struct's layout."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from sensorless.core.api import Array

FIELDS = (
    *("lost", "seed", "start.seek", "sensor.gain_a", "sensor.offset_a"),
    *("profile.omega_ref", "profile.omega_step", "profile.tau", "profile.u_dc"),
    *("drive.x.fault", "drive.x.k_s", "drive.x.start.phase"),
)
"""Numbers of ``sim_t`` that the page reads or writes."""
TABLE_FIELDS = ("crc_values", "crc_header")
"""Those of ``ks_table_t``."""
KINDS = {"float32": "f32", "float64": "f64", "int32": "i32", "uint32": "u32"}
AT_START = ("plant.harmonics.psi_0",)
"""Parameters that the start of a run computes."""


def leaves(dtype: np.dtype[Any], path: str = "", at: int = 0) -> Iterator[tuple[str, int, str]]:
    """Path, offset [bytes] and kind of every number in a record; an array counts once."""
    if dtype.names:
        for name in dtype.names:
            inner, offset = dtype.fields[name][:2]  # type: ignore[index]
            yield from leaves(inner, f"{path}.{name}" if path else name, at + offset)
    elif dtype.subdtype is not None and dtype.subdtype[0].names:
        inner, shape = dtype.subdtype
        for j in range(int(np.prod(shape))):
            yield from leaves(inner, f"{path}[{j}]", at + j * inner.itemsize)
    else:
        yield path, at, KINDS[dtype.base.name]


def offsets(dtype: np.dtype[Any], wanted: tuple[str, ...]) -> dict[str, tuple[int, str]]:
    """Offset and kind of each wanted number.

    Raises
    ------
    KeyError
        The record has no such number.
    """
    found = {path: (at, kind) for path, at, kind in leaves(dtype)}
    return {path: found[path] for path in wanted}


def response(base: Array, doubled: Array) -> list[tuple[int, str, str]]:
    """Offset, kind and ``times`` or ``over`` of each parameter that doubling a quantity changed.

    Raises
    ------
    ValueError
        A parameter is neither proportional nor inversely proportional to the quantity.
    """
    out = []
    for path, at, kind in leaves(base.dtype):
        if path.split(".")[0] not in ("control", "sensor", "plant") or path in AT_START:
            continue
        was, now = _value(base, path), _value(doubled, path)
        if np.array_equal(was, now):
            continue
        if was.ndim or not (now == 2.0 * was or 2.0 * now == was):
            raise ValueError(f"{path}: {was} became {now}; the page can only scale a number")
        out.append((at, kind, "times" if now == 2.0 * was else "over"))
    return out


def _value(record: Array, path: str) -> Array:
    for name in path.split("."):
        record = record[name]
    return np.asarray(record)

"""The drive computes in 32 bits: a design with numbers beyond them is refused before it runs."""

from collections.abc import Iterator

import numpy as np

from sensorless.core.api import Array
from sensorless.errors import UserError
from sensorless.machine.motor import Motor


def require_finite(record: Array, motor: Motor) -> None:
    """Refuse a record of drive parameters with a number that is not finite.

    Raises
    ------
    UserError
        A field is not finite; the message names the machine and the first such field.
    """
    for name, value in _leaves(record, ""):
        if not np.all(np.isfinite(value)):
            raise UserError(
                f"motor {motor.name!r}: {name} of its drive overflows 32-bit numbers; "
                "give the machine in SI units, and try sensorless motor check"
            )


def _leaves(record: Array, path: str) -> Iterator[tuple[str, Array]]:
    names = record.dtype.names
    if names is None:
        yield path, record
        return
    for name in names:
        yield from _leaves(record[name], f"{path}.{name}" if path else name)

"""Scenarios that a user made, checked before they become machines."""

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import PROFILE_N
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.errors import UserError, shown

COLUMNS = {
    **dict.fromkeys(("t", "omega", "omega_rate", "tau", "tau_rate", "u_dc"), PROFILE_N),
    **dict.fromkeys(("gain", "offset"), 2),
}
"""Columns of the fields that have more than one."""
TYPES = {
    "seed": (np.uint64, "iu", "whole numbers"),
    **dict.fromkeys(("seek", "passive", "detailed"), (np.bool_, "b", "True or False")),
}
"""Of the fields that hold no real numbers: the type, the kinds of NumPy it comes from, in words."""
ENDLESS = ("t", "omega_rate", "tau_rate")
"""Fields that may be infinite."""
ABOVE_0 = ("duration", "u_dc", "R_s", "L_q_hat", "psi_f", "J", "gain")
NOT_BELOW_0 = (
    "seed", "t", "omega_rate", "tau_rate", "dead_time", "noise", "p_iron", "u_transistor",
    "u_diode", "ripple", "ripple_hz",
)  # fmt: skip


def checked_scenarios(scenarios: Scenarios, n: int, where: str) -> Scenarios:
    """Return scenarios of n rows as arrays of the right types.

    Raises
    ------
    UserError
        There are more or fewer rows, or a field has another shape, or a number that no machine or
        profile has; the message begins with ``where`` and names field, value and row.
    """
    if np.ndim(scenarios.seed) == 1 and len(scenarios) != n:
        raise UserError(f"{where}: {len(scenarios)} rows; give Scenarios with {n} rows")
    fields = {
        f.name: _array(getattr(scenarios, f.name), f.name, n, f"{where}: {f.name}: ")
        for f in dataclasses.fields(Scenarios)
    }
    t = fields["t"]
    late = np.flatnonzero((t[:, 0] != 0.0) | (t[:, 1:] < t[:, :-1]).any(axis=1))
    if len(late):
        raise UserError(
            f"{where}: t: {shown(t[late[0]].tolist())} in row {late[0]}; begin at 0 and go up"
        )
    return Scenarios(**fields)


def _array(value: object, name: str, n: int, where: str) -> NDArray[Any]:
    """One field as an array (n,) or (n, its columns); errors begin with ``where``."""
    kind, kinds, words = TYPES.get(name, (np.float64, "fiu", "numbers"))
    try:
        x = np.asarray(value)
    except ValueError:  # rows of several lengths
        raise UserError(f"{where}{shown(value)}; give {words}") from None
    shape = (n, COLUMNS[name]) if name in COLUMNS else (n,)
    if x.shape != shape:
        raise UserError(f"{where}shape {x.shape}; give {shape}")
    if x.dtype.kind not in kinds:
        raise UserError(f"{where}{shown(value)}; give {words}")
    good = ~np.isnan(x) if name in ENDLESS else np.isfinite(x)
    words = words if name in (*ENDLESS, *TYPES) else f"finite {words}"
    if name in ABOVE_0:
        good, words = good & (x > 0), f"{words} above 0"
    elif name in NOT_BELOW_0:
        good, words = good & (x >= 0), f"{words}, none below 0"
    if not good.all():
        row = int(np.argmin(good.reshape(n, -1).all(axis=1)))
        bad = x[row][~good[row]].flat[0]
        raise UserError(f"{where}{bad} in row {row}; give {words}")
    return x.astype(kind, copy=False)

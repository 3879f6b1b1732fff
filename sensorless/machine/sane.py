"""Numbers of a motor file that no machine has: refused where a drive is designed.

They are far beyond what ``sensorless motor check`` calls limits: beyond them the simulation itself
overflows. Each message names the field, its value and what to do.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from sensorless.errors import UserError
from sensorless.machine.folds import fold
from sensorless.machine.magnetics import currents
from sensorless.machine.motor import Motor
from sensorless.settings import settings_of
from sensorless.units import rad_per_s

FAR = 10.0
"""Current of a term of [saturation] over the current that the flux linkage should take."""
MAGNET = 1e4
"""Current that cancels the magnet over rated, beyond which its flux map has no inverse."""
SMALL = 0.1
"""Current over rated at which the map has to be near L_q."""


def require_sane(motor: Motor) -> None:
    """Refuse a machine that cannot turn or whose map has nothing to do with its inductances.

    Raises
    ------
    UserError
        Names the machine, the field, its value, and what to do.
    """
    for _, text in insane(motor):
        raise UserError(f"motor {motor.name!r}: {text}")


def insane(m: Motor) -> Iterator[tuple[str, str]]:
    """Each field of which ``require_sane`` would refuse the machine, and why."""
    beyond = [(x.name, x) for x in settings_of(Motor).values() if not x.holds(getattr(m, x.name))]
    for name, setting in beyond:
        meaning = f"must be {setting.allowed} ({setting.meaning})"
        yield name, f"{name} = {getattr(m, name):g}: {meaning}"
    if beyond:
        return
    speed = rad_per_s(m.n_rated_rpm)
    if m.B * speed > m.tau_rated:
        yield (
            "B",
            f"B = {m.B:g} N m s/rad: friction of {m.B * speed:.4g} N m at rated speed, above rated "
            f"torque {m.tau_rated:g} N m; give it in N m s/rad, or 0",
        )
    if m.R_s * m.i_rated > m.u_dc:
        yield (
            "R_s",
            f"R_s = {m.R_s:g} ohm: rated current {m.i_rated:g} A takes {m.R_s * m.i_rated:.4g} V, "
            f"the link has u_dc = {m.u_dc:g} V; give it in ohm, of one phase",
        )
    if m.psi_f > MAGNET * m.L_d * m.i_rated:
        yield (
            "L_d",
            f"L_d = {m.L_d:g} H, psi_f = {m.psi_f:g} Vs: {m.psi_f / m.L_d:.3g} A would cancel the "
            f"magnet, rated current is {m.i_rated:g} A; check the units of the two",
        )
    else:
        yield from _map(m)
    at = fold(m)
    if at is not None:
        yield (
            "flux_correction",
            f"flux_correction: current does not rise with flux near i_d = {at[0]:.3g} A, i_q = "
            f"{at[1]:.3g} A, as it does in a machine; import the flux map anew (sensorless motor "
            "import-map), or remove [flux_correction]",
        )


def _map(m: Motor) -> Iterator[tuple[str, str]]:
    """The map at the magnet's flux and a small q flux; the term whose current is too large."""
    s = m.saturation
    at = np.array([[m.psi_f, SMALL * m.L_q * m.i_rated]])
    likely = FAR * (m.psi_f / m.L_d + m.i_max)
    with np.errstate(all="ignore"):
        whole = currents(s, at)
        if np.abs(whole).max() <= likely:
            return
        names = ("a_dd", "a_qq", "a_dq", "a_b", "a_d0", "a_q0", "i_f")
        without = {k: currents(replace(s, **{k: 0}), at) for k in names}
        part = {k: float(np.abs(whole - i).max()) for k, i in without.items()}
    name = max(part, key=lambda k: part[k])
    yield (
        "saturation",
        f"saturation: {name} = {getattr(s, name):g} gives {part[name]:.3g} A at psi_f = "
        f"{m.psi_f:g} Vs, where the magnet alone needs none; check its unit and exponents, or "
        "remove [saturation]",
    )

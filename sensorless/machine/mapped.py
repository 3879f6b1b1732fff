"""A machine that follows a fitted flux map."""

import dataclasses
from typing import Any

import numpy as np

from sensorless.errors import UserError
from sensorless.machine.flux_correction import correction_table
from sensorless.machine.magnetics import Floats, at_zero_current, mtpa
from sensorless.machine.map_fit import MapFit
from sensorless.machine.motor import Motor, Saturation
from sensorless.machine.motor_file import TABLES
from sensorless.machine.saliency import principal
from sensorless.settings import settings_of


def mapped(motor: Motor, fit: MapFit) -> Motor:
    """The machine with a fitted model, and with the model's L_d, L_q and psi_f at zero current.

    Raises
    ------
    UserError
        The map's d axis is not the magnet's, or the map belongs to another machine.
    """
    s = rounded(fit.saturation)
    L_d, L_q, psi_f = at_zero_current(s, motor.i_rated)
    if psi_f <= 0.0 or L_d >= L_q:
        raise UserError(
            f"map: L_d = {L_d:.4g} H, L_q = {L_q:.4g} H, psi_d = {psi_f:.4g} Vs at zero current; "
            "the magnet must lie along d, and L_q exceed L_d: add --turn, or leave it out if given"
        )
    low, high = principal(motor, np.zeros((1, 2)))[0] * (0.2, 5.0)
    if not (low < L_d < high and low < L_q < high):
        raise UserError(
            f"map: L_d = {L_d:.4g} H, L_q = {L_q:.4g} H at zero current, but the motor file says "
            f"{motor.L_d:g} and {motor.L_q:g} H: another machine, or a wrong unit?"
        )
    return dataclasses.replace(motor, L_d=_six(L_d), L_q=_six(L_q), psi_f=_six(psi_f), saturation=s)


def tables_of(motor: Motor, source: str, base: str, beyond: str) -> dict[str, Any]:
    """Tables of its motor file.

    Parameters
    ----------
    source, beyond, base : str
        Where the map's numbers, its correction, and all others are from.
    """
    from_map = ("L_d", "L_q", "psi_f")
    more = motor.flux_correction
    fields = {**TABLES, "drive": (*TABLES["drive"], *_given(motor))}
    return {
        "name": motor.name,
        "description": motor.description,
        **{table: {f: getattr(motor, f) for f in names} for table, names in fields.items()},
        "saturation": saturation_table(motor.saturation),
        **({} if more is None else {"flux_correction": correction_table(more)}),
        "source": {
            **{
                f: f"{source}, at zero current" if f in from_map else f"as in {base}"
                for names in fields.values()
                for f in names
            },
            "saturation": source,
            **({} if more is None else {"flux_correction": beyond}),
        },
    }


def _given(motor: Motor) -> list[str]:
    """Fields that a motor file may leave out and this one has."""
    usual = {f for fields in TABLES.values() for f in fields}
    rest = [s for name, s in settings_of(Motor).items() if name not in usual]
    return [s.name for s in rest if getattr(motor, s.name) != s.default]


def saturation_table(s: Saturation) -> dict[str, float]:
    """Coefficients that differ from their defaults, or have none."""
    defaults = {f.name: f.default for f in dataclasses.fields(s)}
    return {k: v for k, v in dataclasses.asdict(s).items() if v != defaults[k]}


def rounded(s: Saturation) -> Saturation:
    """The same with six digits a number, as a motor file has it."""
    return Saturation(**{name: _six(x) for name, x in dataclasses.asdict(s).items()})


def _six(x: Any) -> Any:
    """Round to six digits; whole numbers stay as they are."""
    return x if isinstance(x, int) else float(f"{x:.6g}")


LIKELY = 1.33
"""Ratio of a map's value to the motor file's, either way, up to which they belong together."""


def far_from(made: Motor, motor: Motor) -> list[str]:
    """What of a map at zero current is far from the motor file: another unit, or another motor.

    RMS currents make both inductances 1.41 times too large and leave ``psi_f``.
    """
    ratios = {name: getattr(made, name) / getattr(motor, name) for name in ("L_d", "L_q", "psi_f")}
    return [
        f"{name} is {ratio:.2f} times that of the motor file: are the map's currents peak values, "
        "its units right, and is it of this motor?"
        for name, ratio in ratios.items()
        if not 1.0 / LIKELY <= ratio <= LIKELY
    ]


def outside(made: Motor, i: Floats) -> list[str]:
    """Where the drive runs at rated current but a map with currents i (n, 2) [A] has no points."""
    line = mtpa(made)
    last = int(np.searchsorted(np.hypot(*line.T), made.i_rated))
    rest, low, top = 0.05 * made.i_rated, float(i[:, 0].min()), float(np.abs(i[:, 1]).max())
    d, q = line[last].tolist()
    said = []
    if d < low - rest:
        said.append(f"i_d from {low:.3g} A on, but the drive runs at i_d = {d:.3g} A")
    if q > top + rest:
        said.append(f"i_q up to {top:.3g} A, but the drive runs at i_q = {q:.3g} A")
    return [
        f"the map has {what} at rated current: there the fit is a guess; measure up to i_max, with "
        "negative i_d"
        for what in said
    ]

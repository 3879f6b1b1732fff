"""The description of an open-loop run of the machine alone, in JSON.

It gives the machine (``linear`` or ``pmsyrm``), the mechanics (``J`` and ``B``, or a held speed
``w_M``), the start (``init``) and the period ``T_s``. A capital ``M`` marks mechanical quantities,
a small ``m`` electrical ones.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sensorless.errors import UserError
from sensorless.files import read_json
from sensorless.machine.motor import Saturation

EXPONENTS = ("S", "T", "U", "V", "W")
SATURATED = tuple("n_p R_s a_d0 a_dd S a_q0 a_qq T a_dq U V".split())
BRIDGE = ("a_b", "a_bp", "k_q", "psi_n", "W")
POSITIVE = ("T_s", "L_d", "L_q", "a_d0", "a_q0", "J")
INIT = {"i_d": "i_d", "i_q": "i_q", "theta_m": "theta_e", "w_M": "omega_m"}
"""Keys of ``init`` and what they are called here."""
NOTES = ("rtol", "atol")
"""Keys that say how a reference was made; they are ignored."""


@dataclass(frozen=True)
class PlantCase:
    """A machine with its mechanics and its start. SI units, peak values."""

    T_s: float
    """period over which the inputs are held [s]"""
    n_p: int
    """pole pairs"""
    R_s: float
    """[ohm]"""
    saturation: Saturation
    J: float
    """inertia [kg m^2]; infinite when the speed is held"""
    B: float
    """viscous friction [N m s/rad]"""
    i_d: float
    """current at the start [A]"""
    i_q: float
    theta_e: float
    """electrical angle at the start [rad]"""
    omega_m: float
    """mechanical speed at the start, or the held one [rad/s]"""


def read_case(path: str | Path) -> PlantCase:
    """Read the JSON description of a run.

    Raises
    ------
    UserError
        The file cannot be read, or a field is missing, unknown or out of range.
    """
    try:
        data = read_json(Path(path))
    except OSError as error:
        raise UserError(
            f"plant {str(path)!r}: {error.strerror}; give a file that can be read"
        ) from None
    except ValueError as error:
        raise UserError(f"plant {str(path)!r}: not a valid JSON file: {error}") from None
    return case_from(data, str(path))


def case_from(data: Any, where: str) -> PlantCase:
    """Check the parsed JSON field by field; ``where`` opens every message.

    Raises
    ------
    UserError
        A field is missing, unknown or out of range.
    """
    if not isinstance(data, dict):
        raise UserError(f"{where}: give an object with T_s, machine, mechanics and init")
    top = {key: value for key, value in data.items() if key not in NOTES}
    tables = {}
    for key in ("machine", "mechanics", "init"):
        tables[key] = top.pop(key, None)
        if not isinstance(tables[key], dict):
            what = "missing" if tables[key] is None else f"{tables[key]!r}"
            raise UserError(f"{where}: {key}: {what}; give an object")
    T_s = _numbers(top, ("T_s",), where)["T_s"]
    n_p, R_s, saturation = _machine(dict(tables["machine"]), f"{where}: machine")
    held = "w_M" in tables["mechanics"]
    mechanics = _numbers(
        tables["mechanics"], ("w_M",) if held else ("J", "B"), f"{where}: mechanics"
    )
    init = _numbers(tables["init"], tuple(INIT), f"{where}: init")
    if held and init["w_M"] != mechanics["w_M"]:
        raise UserError(
            f"{where}: init: w_M: {init['w_M']:g}; give the held speed, {mechanics['w_M']:g} rad/s"
        )
    return PlantCase(
        T_s=T_s,
        n_p=n_p,
        R_s=R_s,
        saturation=saturation,
        J=mechanics.get("J", math.inf),
        B=mechanics.get("B", 0.0),
        **{INIT[key]: value for key, value in init.items()},
    )


def _machine(values: dict[str, Any], where: str) -> tuple[int, float, Saturation]:
    """Pole pairs, resistance [ohm] and flux map of the table ``machine``."""
    kind = values.pop("type", None)
    if kind == "linear":
        v = _numbers(values, ("n_p", "R_s", "L_d", "L_q", "psi_f"), where)
        saturation = Saturation.linear(v["L_d"], v["L_q"], v["psi_f"])
        return int(v["n_p"]), v["R_s"], saturation
    if kind != "pmsyrm":
        raise UserError(f"{where}: type: {kind!r}; choose linear or pmsyrm")
    needed = SATURATED
    needed += BRIDGE if any(name in values for name in BRIDGE) else ()
    needed += ("i_f",) if "i_f" in values else ()
    v = _numbers(values, needed, where)
    n_p, R_s = int(v.pop("n_p")), v.pop("R_s")
    coefficients: dict[str, Any] = {k: int(x) if k in EXPONENTS else x for k, x in v.items()}
    return n_p, R_s, Saturation(**coefficients)


def _numbers(values: dict[str, Any], names: tuple[str, ...], where: str) -> dict[str, float]:
    """Exactly the numbers ``names``, each finite and in its range."""
    unknown = [name for name in values if name not in names]
    if unknown:
        raise UserError(f"{where}: {unknown[0]}: unknown field; known are {', '.join(names)}")
    return {name: _number(name, values, where) for name in names}


def _number(name: str, values: dict[str, Any], where: str) -> float:
    if name not in values:
        raise UserError(f"{where}: {name}: missing; give {_range(name)}")
    value = values[name]
    good = isinstance(value, (int, float)) and not isinstance(value, bool)
    good = good and abs(value) < 1e300  # false for NaN
    if good and name in (*EXPONENTS, "n_p"):
        low, high = (1, 100) if name == "n_p" else (0, 7)
        good = value == int(value) and low <= value <= high
    elif good and name not in INIT:
        good = value > 0 if name in POSITIVE else value >= 0
    if not good:
        raise UserError(f"{where}: {name}: {value!r}; give {_range(name)}")
    return float(value)


def _range(name: str) -> str:
    if name in EXPONENTS:
        return "a whole number from 0 to 7"
    if name == "n_p":
        return "a whole number from 1 to 100"
    if name in INIT:
        return "a finite number"
    return f"a finite number {'above 0' if name in POSITIVE else 'of at least 0'}"

"""One machine and its drive hardware, read from a TOML file and checked field by field."""

import dataclasses
import hashlib
import json
import math
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from sensorless.errors import UserError

MOTORS = Path(__file__).parent / "motors"


def _number(doc: str, low: float = 1e-12, *, open_low: bool = True, high: float = 1e12) -> Any:
    """Dataclass field of a number in (low, high], or [low, high] when ``open_low`` is false.

    The default bounds are wider than any machine, and no product of a few leaves float32.
    """
    return field(metadata={"doc": doc, "low": low, "open": open_low, "high": high})


@dataclass(frozen=True)
class Saturation:
    """Coefficients of the flux map in ``core/sim/flux_map.h`` (doi 10.1109/TIA.2016.2644624)."""

    a_d0: float = _number("[1/H]")
    a_q0: float = _number("[1/H]")
    i_f: float = field(default=0.0, metadata={"doc": "magnet current [A]", "low": 0.0})
    a_dd: float = field(default=0.0, metadata={"doc": "[1/(H Vs^S)]", "low": 0.0})
    S: int = field(default=0, metadata={"doc": "exponent", "low": 0, "high": 7})
    a_qq: float = field(default=0.0, metadata={"doc": "[1/(H Vs^T)]", "low": 0.0})
    T: int = field(default=0, metadata={"doc": "exponent", "low": 0, "high": 7})
    a_dq: float = field(default=0.0, metadata={"doc": "cross term", "low": 0.0})
    U: int = field(default=0, metadata={"doc": "exponent", "low": 0, "high": 5})
    V: int = field(default=0, metadata={"doc": "exponent", "low": 0, "high": 5})
    a_b: float = field(default=0.0, metadata={"doc": "bridge [1/(H Vs^W)]", "low": 0.0})
    a_bp: float = field(default=0.0, metadata={"doc": "bridge [1/Vs^W]", "low": 0.0})
    k_q: float = field(default=0.0, metadata={"doc": "bridge, q weight", "low": 0.0})
    psi_n: float = field(default=0.0, metadata={"doc": "bridge flux [Vs]", "low": 0.0})
    W: int = field(default=0, metadata={"doc": "bridge exponent", "low": 0, "high": 7})

    @classmethod
    def linear(cls, L_d: float, L_q: float, psi_f: float) -> "Saturation":
        """Constant inductances [H] and magnet flux [Vs]."""
        return cls(a_d0=1.0 / L_d, a_q0=1.0 / L_q, i_f=psi_f / L_d)


@dataclass(frozen=True)
class Motor:
    """A machine with its inverter and sensors: SI units, peak values.

    ``L_d``, ``L_q`` and ``psi_f`` describe the machine at zero current (what a data sheet gives);
    ``saturation`` is what the simulated machine follows.
    """

    name: str
    description: str
    n_p: int = _number("pole pairs", 1, open_low=False, high=100)
    R_s: float = _number("stator resistance [ohm]")
    L_d: float = _number("d inductance at zero current [H]")
    L_q: float = _number("q inductance at zero current [H]")
    psi_f: float = _number("magnet flux linkage [Vs]")
    J: float = _number("inertia [kg m^2]")
    B: float = _number("viscous friction [N m s/rad]", 0.0, open_low=False)
    tau_rated: float = _number("rated torque [N m]")
    i_rated: float = _number("rated current, peak [A]")
    n_rated_rpm: float = _number("rated speed [r/min]")
    u_dc: float = _number("DC-link voltage [V]")
    T_s: float = _number("PWM period [s]", 1e-6, open_low=False, high=1e-3)
    u_inj: float = _number("injected voltage [V]")
    i_max: float = _number("current limit of the control, peak [A]")
    i_trip: float = _number("over-current trip, peak [A]")
    dead_time: float = _number("dead time of a leg [s]", 0.0, open_low=False)
    adc_range: float = _number("largest measurable current [A]")
    adc_bits: int = _number("resolution of the current measurement", 4, open_low=False, high=32)
    saturation: Saturation = field(kw_only=True)

    @property
    def omega_rated(self) -> float:
        """Rated electrical speed [rad/s]."""
        return self.n_p * self.n_rated_rpm * math.pi / 30.0

    @property
    def digest(self) -> str:
        """SHA-256 over all numbers of the machine, hexadecimal."""
        values = dataclasses.asdict(self)
        values.pop("description")
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    def rpm_to_electrical(self, rpm: float) -> float:
        """Speed in r/min to electrical rad/s."""
        return self.n_p * rpm * math.pi / 30.0

    @classmethod
    def load(cls, name: str | Path) -> "Motor":
        """Read a shipped machine by name, or any TOML file by path.

        Raises
        ------
        UserError
            Names the file and the field that is missing, unknown or out of range.
        """
        path = Path(name)
        if path.suffix != ".toml":
            path = MOTORS / f"{name}.toml"
        if not path.is_file():
            known = ", ".join(sorted(p.stem for p in MOTORS.glob("*.toml")))
            raise UserError(f"motor {str(name)!r}: no such file; shipped motors: {known}")
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError, OSError) as error:  # TOMLDecodeError is a ValueError
            raise UserError(f"{path}: not a valid TOML file: {error}") from None
        return _from_tables(data, str(path))

    @classmethod
    def from_tables(cls, data: dict[str, Any], where: str) -> "Motor":
        """Machine of the tables of a TOML file; errors as in ``load``, under the name ``where``."""
        return _from_tables(dict(data), where)


def _from_tables(data: dict[str, Any], where: str) -> Motor:
    tables = {key: data.pop(key, {}) for key in ("machine", "rating", "drive")}
    sat = data.pop("saturation", None)
    data.pop("source", None)
    values: dict[str, Any] = dict(data)
    for key, table in tables.items():
        if not isinstance(table, dict):
            raise UserError(f"{where}: {key}: must be a table, got {table!r}")
        values.update(table)
    for text in ("name", "description"):
        if not isinstance(values.get(text), str):
            raise UserError(f"{where}: {text}: missing; allowed: a string")
    numbers = _checked(Motor, values, where, skip=("name", "description", "saturation"))
    if sat is None:
        saturation = Saturation.linear(numbers["L_d"], numbers["L_q"], numbers["psi_f"])
    elif isinstance(sat, dict):
        saturation = Saturation(**_checked(Saturation, sat, f"{where}: saturation"))
    else:
        raise UserError(f"{where}: saturation: must be a table, got {sat!r}")
    if numbers["i_trip"] <= numbers["i_max"]:
        raise UserError(
            f"{where}: i_trip: {numbers['i_trip']} A; allowed: above i_max = {numbers['i_max']} A"
        )
    return Motor(
        name=values["name"], description=values["description"], saturation=saturation, **numbers
    )


def _checked(
    cls: type, values: dict[str, Any], where: str, skip: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Numbers of ``cls`` from ``values``, each present, of its type and in its range."""
    fields = {f.name: f for f in dataclasses.fields(cls) if f.name not in skip}
    unknown = sorted(set(values) - set(fields) - set(skip))
    if unknown:
        raise UserError(f"{where}: {unknown[0]}: unknown field; allowed: {', '.join(fields)}")
    out = {}
    for name, f in fields.items():
        if name not in values:
            if f.default is dataclasses.MISSING:
                raise UserError(f"{where}: {name}: missing; {f.metadata['doc']}")
            continue
        out[name] = _number_in_range(name, values[name], f, where)
    return out


def _number_in_range(name: str, value: Any, f: "dataclasses.Field[Any]", where: str) -> float:
    low, high = f.metadata["low"], f.metadata.get("high", math.inf)
    is_open = f.metadata.get("open", False)
    bounds = f"{'above' if is_open else 'at least'} {low:g}"
    bounds += f" and at most {high:g}" if math.isfinite(high) else ""
    whole = f.type in (int, "int")
    kind = "a whole number" if whole else "a finite number"
    good = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool)
    good = good and abs(value) < 1e300 and (value > low if is_open else value >= low)
    if not (good and value <= high):
        raise UserError(
            f"{where}: {name}: {value!r}; allowed: {kind}, {bounds} ({f.metadata['doc']})"
        )
    return int(value) if whole else float(value)

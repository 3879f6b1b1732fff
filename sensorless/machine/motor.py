"""One machine and its drive hardware, read from a TOML file and checked field by field."""

import dataclasses
import hashlib
import json
import math
import sys
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Integral, Real
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from sensorless.errors import UserError, has_control, like, shown
from sensorless.files import is_device
from sensorless.machine.flux_correction import FluxCorrection, read_correction
from sensorless.settings import REQUIRED, derived, is_finite, number, read, settings_of, switch
from sensorless.units import rad_per_s

MOTORS = Path(__file__).parent / "motors"
INF = math.inf


def positive(unit: str, meaning: str) -> Any:
    """Field of a number above zero without a default.

    Its bounds are wider than any machine; products of a few such numbers stay within float32.
    """
    return number(REQUIRED, unit, 1e-12, 1e12, meaning, above=True)


@dataclass(frozen=True)
class Saturation:
    """Coefficients of the flux map in ``core/sim/flux_map.h`` (doi 10.1109/TIA.2016.2644624)."""

    a_d0: float = positive("1/H", "d axis without saturation")
    a_q0: float = positive("1/H", "q axis without saturation")
    i_f: float = number(0.0, "A", 0, INF, "magnet current")
    a_dd: float = number(0.0, "1/(H Vs^S)", 0, INF, "saturation of the d axis")
    S: int = number(0, "1", 0, 7, "exponent of the d axis")
    a_qq: float = number(0.0, "1/(H Vs^T)", 0, INF, "saturation of the q axis")
    T: int = number(0, "1", 0, 7, "exponent of the q axis")
    a_dq: float = number(0.0, "A/Vs^(U+V+3)", 0, INF, "cross-saturation")
    U: int = number(0, "1", 0, 5, "exponent of the d flux in cross-saturation")
    V: int = number(0, "1", 0, 5, "exponent of the q flux in cross-saturation")
    a_b: float = number(0.0, "1/(H Vs^W)", 0, INF, "bridges; 0: none")
    a_bp: float = number(0.0, "1/Vs^W", 0, INF, "saturation of the bridges")
    k_q: float = number(0.0, "1", 0, INF, "weight of the q flux in the bridges")
    psi_n: float = number(0.0, "Vs", 0, INF, "d flux linkage at which the bridges carry none")
    W: int = number(0, "1", 0, 7, "exponent of the bridges")

    def __post_init__(self) -> None:
        """Check that every number is one, as ``_numbers``."""
        _numbers(self, "saturation: ")

    @classmethod
    def linear(cls, L_d: float, L_q: float, psi_f: float) -> "Saturation":
        """Constant inductances [H] and magnet flux [Vs]."""
        return cls(a_d0=1.0 / L_d, a_q0=1.0 / L_q, i_f=psi_f / L_d)


@dataclass(frozen=True)
class Motor:
    """A machine with its inverter and sensors: SI units, peak values.

    ``L_d``, ``L_q`` and ``psi_f`` describe the machine at zero current (what a datasheet gives);
    the drive is designed on ``saturation``, which the simulated machine follows with
    ``flux_correction`` on top. The fields from ``emf_5`` on describe the
    simulated machine alone; no controller uses them. The no-load EMF of a phase is
    -omega psi_f (sin theta + emf_5 sin 5 theta + emf_7 sin 7 theta), and a second saliency of
    ``saliency_6`` times (1/L_d - 1/L_q) / 2 turns six times as fast as the rotor, seen from it.
    """

    name: str
    description: str
    n_p: int = number(REQUIRED, "1", 1, 100, "pole pairs")
    R_s: float = positive("ohm", "stator resistance")
    L_d: float = positive("H", "d inductance at zero current")
    L_q: float = positive("H", "q inductance at zero current")
    psi_f: float = positive("Vs", "magnet flux linkage")
    J: float = positive("kg m^2", "inertia")
    B: float = number(REQUIRED, "N m s/rad", 0, 1e12, "viscous friction")
    tau_rated: float = positive("N m", "rated torque")
    i_rated: float = positive("A", "rated current, peak")
    n_rated_rpm: float = positive("r/min", "rated speed")
    u_dc: float = positive("V", "DC-link voltage")
    T_s: float = number(REQUIRED, "s", 1e-6, 1e-3, "PWM period")
    u_inj: float = positive("V", "injected voltage")
    i_max: float = positive("A", "current limit of the control, peak")
    i_trip: float = positive("A", "over-current trip, peak")
    dead_time: float = number(REQUIRED, "s", 0, 1e12, "dead time of a leg")
    adc_range: float = positive("A", "largest current that is measured, peak")
    adc_bits: int = number(REQUIRED, "1", 4, 32, "bits of the current measurement")
    speed_hz: float | None = derived("Hz", 0.1, 50, "speed loop that the application asks for")
    pole_at_rest: bool = switch(True, "whether a drive may seek the pole of a rotor at rest")
    emf_5: float = number(0.0, "1", -0.5, 0.5, "5th harmonic of the no-load EMF over the first")
    emf_7: float = number(0.0, "1", -0.5, 0.5, "7th harmonic of the no-load EMF over the first")
    saliency_6: float = number(0.0, "1", -0.5, 0.5, "second saliency over the first")
    p_iron: float = number(0.0, "W", 0, 1e12, "iron loss at rated speed without load")
    u_transistor: float = number(0.0, "V", 0, 10, "threshold voltage of a transistor")
    u_diode: float = number(0.0, "V", 0, 10, "threshold voltage of a diode")
    winding_per_K: float = number(0.00393, "1/K", 0, 0.01, "temperature coefficient of R_s")
    magnet_per_K: float = number(-0.0011, "1/K", -0.01, 0, "temperature coefficient of psi_f")
    saturation: Saturation = field(kw_only=True)
    flux_correction: FluxCorrection | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check that every number is one, as ``_numbers``; ``require_sane`` checks its range."""
        _numbers(self, f"motor {self.name!r}: ")

    @property
    def omega_rated(self) -> float:
        """Rated electrical speed [rad/s]."""
        return rad_per_s(self.n_p * self.n_rated_rpm)

    @property
    def omega_m_rated(self) -> float:
        """Rated mechanical speed [rad/s]."""
        return self.omega_rated / self.n_p

    @property
    def dead_time_voltage(self) -> float:
        """Mean voltage that a leg loses to the dead time [V]."""
        return self.u_dc * self.dead_time / self.T_s

    @cached_property
    def digest(self) -> str:
        """SHA-256 over all numbers of the machine, hexadecimal.

        Fields at their defaults do not count, so new fields leave old digests unchanged.
        """
        values = dataclasses.asdict(self)
        values.pop("description")
        for f in dataclasses.fields(self):
            if f.default is not dataclasses.MISSING and values[f.name] == f.default:
                values.pop(f.name)
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    def rpm_to_electrical(self, rpm: float) -> float:
        """Speed in r/min to electrical rad/s."""
        return rad_per_s(self.n_p * rpm)

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
            known = sorted(p.stem for p in MOTORS.glob("*.toml"))
            what = "a folder: give a .toml file" if name and Path(name).is_dir() else "no such file"
            if Path(name).is_file():
                what = "the name of a motor file ends in .toml"
            if is_device(Path(name)):
                what = "no regular file: give a .toml file"
            hint = like(str(name), known) if what == "no such file" else ""
            raise UserError(
                f"motor {str(name)!r}: {what}; {hint}shipped motors: {', '.join(known)}"
            )
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        except RecursionError:
            what = "nested too deeply; write [machine], [rating] and [drive]"
            raise UserError(f"{path}: not a motor file: {what}") from None
        except (ValueError, OSError) as error:  # TOMLDecodeError is a ValueError
            what = "a number has too many digits" if type(error) is ValueError else str(error)
            if isinstance(error, UnicodeDecodeError):
                what = "its text is not in UTF-8; save it as UTF-8"
            raise UserError(f"{path}: not a valid TOML file: {what}") from None
        return _from_tables(data, str(path))

    @classmethod
    def from_tables(cls, data: dict[str, Any], where: str) -> "Motor":
        """Machine from the tables of a TOML file; ``where`` names it in errors, see ``load``."""
        return _from_tables(dict(data), where)


def _numbers(owner: Motor | Saturation, where: str) -> None:
    """Make numbers of Python of all settings, whatever NumPy has made of them.

    Raises
    ------
    UserError
        Names the field that is no finite number, or nothing else of its kind.
    """
    cls: type = type(owner)
    for name, setting in settings_of(cls).items():
        x = getattr(owner, name)
        if x is None and setting.derived:
            continue
        if setting.kind is bool:
            setting.checked(x, where)
            continue
        kind = Integral if setting.kind is int else Real
        if not isinstance(x, kind) or isinstance(x, bool) or not is_finite(x):
            setting.checked(x, where)
        object.__setattr__(owner, name, setting.kind(x))


def check_name(name: str, where: str = "") -> None:
    """Refuse the name of a machine that would break lines of reports and of exported code.

    Raises
    ------
    UserError
        It is blank, or has control characters.
    """
    if not name.strip():
        raise UserError(f"{where}name: {shown(name)}: give a text")
    if has_control(name):
        raise UserError(f"{where}name: {shown(name)}: leave out control characters")


KNOWN_TABLES = ("machine", "rating", "drive", "saturation", "flux_correction", "source")


def _from_tables(data: dict[str, Any], where: str) -> Motor:
    tables = {key: data.pop(key, {}) for key in KNOWN_TABLES[:3]}
    sat = data.pop("saturation", None)
    correction = read_correction(data.pop("flux_correction", None), f"{where}: flux_correction")
    data.pop("source", None)
    for key, value in data.items():
        if isinstance(value, dict):
            known = ", ".join(f"[{name}]" for name in KNOWN_TABLES)
            raise UserError(f"{where}: [{key}]: unknown table; choose from {known}")
    values: dict[str, Any] = dict(data)
    for key, table in tables.items():
        if not isinstance(table, dict):
            raise UserError(f"{where}: {key}: must be a table, got {shown(table)}")
        values.update(table)
    texts = {}
    for text in ("name", "description"):
        texts[text] = values.pop(text, None)
        if texts[text] is None:
            raise UserError(f"{where}: {text}: missing: give a text")
        if not isinstance(texts[text], str) or (text == "name" and not texts[text].strip()):
            raise UserError(f"{where}: {text}: {shown(texts[text])}: must be a text")
    check_name(texts["name"], f"{where}: ")
    numbers = read(Motor, values, f"{where}: ")
    if sat is None:
        saturation = Saturation.linear(numbers["L_d"], numbers["L_q"], numbers["psi_f"])
    elif isinstance(sat, dict):
        saturation = Saturation(**read(Saturation, sat, f"{where}: saturation: "))
    else:
        raise UserError(f"{where}: saturation: must be a table, got {shown(sat)}")
    if numbers["i_trip"] <= numbers["i_max"]:
        raise UserError(
            f"{where}: i_trip: {numbers['i_trip']} A: must be above i_max = {numbers['i_max']} A"
        )
    return Motor(**texts, saturation=saturation, flux_correction=correction, **numbers)

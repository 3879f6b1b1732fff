"""What a run, a tuned rule or a table carries: its machine, and every setting of its drive.

A file records the machine whole (``machine``), the settings that were chosen (``set``), and for
comparison all settings as they stood then (``design``) and fingerprints of the numbers that they
became (``gains``). A setting that nobody chose follows from the design of the version that reads
the file.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.fingerprint import fingerprint
from sensorless.design.words import text_of
from sensorless.errors import UserError, shown
from sensorless.machine.motor import MOTORS, Motor
from sensorless.settings import read, settings_of

UNRECORDED = "smo"
"""Estimator of a file that names none: such files are older than the choice of estimators."""
BELONGS = ("k_s_slew",)
"""Numbers that are recorded even at their defaults: the schedule itself is made for them."""

RESTORE = "restore the file, or make it anew"


def commands_of(origin: Mapping[str, Any]) -> list[str]:
    """Every command that made a schedule, in order: the first, and those that went on with it."""
    more = origin.get("resumed")
    known = [origin, *(more if isinstance(more, list) else [])]
    return [
        str(part["command"]) for part in known if isinstance(part, Mapping) and part.get("command")
    ]


@dataclass(frozen=True)
class Carried:
    """Machine and settings that a file brings along."""

    settings: Mapping[str, Any]
    """Every setting of ``DriveDesign``; a file older than that brings those that it names."""
    motor: Motor | None
    """None: any machine, or one that the file only names."""
    made_for: tuple[str, str] | None
    """Name and digest of its machine; None: any."""
    changed: Mapping[str, tuple[Any, Any]]
    """Settings that nobody chose and that have changed since: then and now."""
    gains: Mapping[str, str]
    """``fingerprint`` as it was; empty if it is not recorded."""

    def other_gains(self) -> list[str]:
        """Parts of the drive that the same settings make otherwise today."""
        if self.motor is None or not self.gains:
            return []
        now = fingerprint(self.motor, DriveDesign(**self.settings))
        return [part for part in now if now[part] != self.gains.get(part)]


def record(design: DriveDesign, motor: Motor | None = None) -> dict[str, Any]:
    """Entries of a provenance that ``carried`` reads; no motor: made for any machine."""
    out = {"set": chosen(design), "design": worded(dataclasses.asdict(design))}
    if motor is None:
        return out
    machine = dataclasses.asdict(motor)
    if motor.flux_correction is None:
        machine.pop("flux_correction")
    return {"machine": machine, **out, "gains": fingerprint(motor, design)}


def chosen(design: DriveDesign) -> dict[str, Any]:
    """Words and switches, which no formula gives, and the numbers that are not the default."""
    values = {
        name: getattr(design, name)
        for name, setting in settings_of(DriveDesign).items()
        if setting.kind in (str, bool)
        or name in BELONGS
        or getattr(design, name) != setting.default
    }
    return worded(values)


def worded(values: Mapping[str, Any]) -> dict[str, Any]:
    """Convert to JSON types: infinity becomes a word."""
    return {k: str(v) if v in (math.inf, -math.inf) else v for k, v in values.items()}


def carried(provenance: Mapping[str, Any], where: str) -> Carried:
    """Read what ``record`` wrote, or what earlier versions wrote in its place.

    Raises
    ------
    UserError
        A setting or a field of the machine is unknown or out of its range, or they are missing or
        contradict the rest; ``where`` names the file.
    """
    given, whole = (_settings(provenance, key, where) for key in ("set", "design"))
    if "machine" in provenance and not {"set", "design"} & set(provenance):
        raise UserError(f"{where}: set, design: missing beside the machine; {RESTORE}")
    changed = {}
    motor = _motor(provenance, where)
    if given:
        design = DriveDesign(**read(DriveDesign, given, f"{where}: set: "))
        settings = dataclasses.asdict(design)
        now = numbers(settings, motor)
        changed = {
            name: (whole[name], now[name])
            for name in settings
            if whole.get(name) is not None
            and name not in given
            and not same(whole[name], now[name])
        }
    else:
        settings = {"estimator": UNRECORDED} | read(DriveDesign, whole, f"{where}: design: ")
    named = provenance.get("motor", "?"), provenance.get("motor_digest")
    made_for = (str(named[0]), str(named[1])) if named[1] is not None else None
    if motor is not None:
        made_for = motor.name, motor.digest
    gains = provenance.get("gains")
    return Carried(settings, motor, made_for, changed, gains if isinstance(gains, dict) else {})


def numbers(settings: Mapping[str, Any], motor: Motor | None) -> dict[str, Any]:
    """Settings whose automatic numbers are those of a machine, to five digits."""
    if motor is None or None not in settings.values():
        return dict(settings)
    by = dataclasses.asdict(derive(motor, DriveDesign(**settings)))
    return {k: float(f"{by[k]:.5g}") if v is None else v for k, v in settings.items()}


def same(a: object, b: object) -> bool:
    """Whether two values of a setting are equal; numbers to the digits that texts show."""
    both = isinstance(a, float | int) and isinstance(b, float | int)
    return math.isclose(a, b, rel_tol=1e-4) if both else a == b  # type: ignore[arg-type]


def _settings(provenance: Mapping[str, Any], key: str, where: str) -> dict[str, Any]:
    """Undo ``plain``; empty if there are none."""
    values = provenance.get(key, {})
    if not isinstance(values, dict):
        raise UserError(f"{where}: {key}: {shown(values)} holds no settings by name; {RESTORE}")
    for name, value in values.items():
        if not (isinstance(value, str | float | None) or _is_whole(value)):
            raise UserError(
                f"{where}: {key}: {name}: {shown(value)}: must be a number, a word, true, false or "
                f"null; {RESTORE}"
            )
    return {k: float(v) if v in ("inf", "-inf") else v for k, v in values.items()}


def _is_whole(value: object) -> bool:
    """Whether a value is true, false or a whole number that a float can hold."""
    return isinstance(value, int) and abs(value) < 2**1023


def _motor(provenance: Mapping[str, Any], where: str) -> Motor | None:
    """The machine of a file; of one that only names it, the shipped one of this digest."""
    tables, digest = provenance.get("machine"), provenance.get("motor_digest")
    if isinstance(tables, dict):
        motor = Motor.from_tables(tables, f"{where}: machine")
        if digest not in (None, motor.digest):
            raise UserError(
                f"{where}: motor_digest: {shown(digest)}, but that of its machine is "
                f"{motor.digest[:16]}...: one of the two was changed; {RESTORE}"
            )
        return motor
    shipped = map(Motor.load, sorted(MOTORS.glob("*.toml")) if digest is not None else ())
    return next((motor for motor in shipped if motor.digest == digest), None)


def refuse_other(known: Carried, motor: Motor, word: str, why: str = "was asked for") -> None:
    """Refuse a machine that a schedule was not made for; ``why`` tells where it comes from.

    Raises
    ------
    UserError
        Names the schedule by ``word``, its machine and the one asked for; of two machines of one
        name also what differs.
    """
    made_for = known.made_for
    if made_for is None or made_for[1] == motor.digest:
        return
    other = "" if known.motor is None else _difference(known.motor, motor)
    raise UserError(
        f"motor: {motor.name} {why}, digest {motor.digest[:16]}, but {word} was made for "
        f"{made_for[0]}, digest {made_for[1][:16]}{other}: use that, or add --override"
    )


def _difference(then: Motor, now: Motor) -> str:
    """What differs between two machines of one name."""
    if then.name != now.name:
        return ""
    names = [f.name for f in dataclasses.fields(Motor) if f.name != "description"]
    pairs = ((name, getattr(then, name), getattr(now, name)) for name in names)
    texts = [f"{name} = {shown(a)} instead of {shown(b)}" for name, a, b in pairs if a != b]
    return (
        f", with {texts[0]}" + (f" and {len(texts) - 1} more" if texts[1:] else "") if texts else ""
    )


def refuse_settings(
    brought: Mapping[str, Any],
    asked: Mapping[str, Any],
    word: str,
    motor: Motor | None = None,
    way_out: str = "add --override",
) -> None:
    """Refuse settings that contradict those that a policy made for ``motor`` brings.

    Raises
    ------
    UserError
        Names the policy by ``word``, its value and the one asked for.
    """
    settings = numbers(brought, motor)
    for name, value in asked.items():
        if name not in settings or value == brought[name]:
            continue
        if not same(settings[name], value):
            raise UserError(
                f"set: {name}={text_of(value)} was asked for, but {word} brings "
                f"{name}={text_of(settings[name])}: leave it out, or {way_out}"
            )

"""Settings: name, default, unit, range or choices, and meaning, each written down once.

A dataclass declares its settings as fields: ``number``, ``switch`` or ``word``. All code that
reads, checks, lists or documents them gets them from ``settings_of``.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any

from sensorless.errors import UserError, shown

REQUIRED: Any = dataclasses.MISSING
"""Default of a setting that must be given."""
SWITCH = {"true": True, "false": False}
AUTO = "auto"
"""Word for a number that follows from the machine."""
LARGEST = 1e300
"""Larger numbers count as infinite: a whole number may be too large for a double."""


@dataclass(frozen=True)
class Setting:
    """One setting."""

    name: str
    default: Any
    """``REQUIRED`` if there is none."""
    unit: str
    """``"1"`` for a plain number, empty for a setting that is not a number."""
    low: float
    high: float
    meaning: str
    kind: type = float
    """float, int, bool or str."""
    above: bool = False
    """Whether ``low`` itself is out of range."""
    endless: bool = False
    """Whether infinity is in range."""
    choices: Mapping[str, str] = field(default_factory=dict, hash=False)
    """Words that it may be, each with its meaning; ``FILE.json`` is any file with that suffix.
    Empty: any word."""
    renamed: Mapping[str, str] = field(default_factory=dict, hash=False)
    """Words of earlier versions, and those that replace them."""
    was: str = ""
    """Name of a setting of earlier versions that this one replaces."""
    derived: bool = False
    """Whether None, or the word ``AUTO``, leaves it to a formula."""

    @property
    def allowed(self) -> str:
        """Range with unit, or choices, as a message names them."""
        if self.kind is bool:
            return " or ".join(SWITCH)
        if self.kind is str:
            words = list(self.choices)
            return " or ".join(filter(None, (", ".join(words[:-1]), *words[-1:]))) or "text"
        if self.derived:
            return f"{dataclasses.replace(self, derived=False).allowed}, or {AUTO}"
        unit = "" if self.unit == "1" else f" {self.unit}"
        if self.high == math.inf:
            text = f"{'above' if self.above else 'at least'} {self.low:.12g}{unit}"
            return text + (", or inf" if self.endless else "")
        if self.above:
            return f"above {self.low:.12g} and at most {self.high:.12g}{unit}"
        return f"between {self.low:.12g} and {self.high:.12g}{unit}"

    @property
    def sentence(self) -> str:
        """Meaning, choices with their meanings, range and unit: the text of an option's help."""
        text = self.meaning + "".join(f"; {word}: {doc}" for word, doc in self.choices.items())
        limits = f" ({self.allowed})" if self.kind in (int, float) else ""
        return f"{text[0].upper()}{text[1:]}{limits}."

    def holds(self, value: object) -> bool:
        """Whether a value is of the kind of the setting and in its range."""
        if self.derived and value is None:
            return True
        if self.kind is bool:
            return isinstance(value, bool)
        if self.kind is str:
            known = not self.choices or any(_is(value, choice) for choice in self.choices)
            return isinstance(value, str) and known
        if not _is_number(value) or (self.kind is int and not isinstance(value, Integral)):
            return False
        x: Any = value
        above = x > self.low if self.above else x >= self.low
        return bool(above and x <= self.high and (is_finite(x) or self.endless))

    def checked(self, value: object, where: str = "") -> Any:
        """Value converted to the kind of the setting.

        Parameters
        ----------
        value : object
        where : str
            Start of the message, for example the name of a file.

        Raises
        ------
        UserError
            Names the setting, the value, what it must be, and what it means.
        """
        if self.holds(value):
            return value if value is None else self.kind(value)
        if isinstance(value, str) and value in self.renamed:
            now = self.renamed[value]
            raise UserError(f"{where}{self.name}: {value!r} is now called {now!r}: write {now}")
        kind = ""
        if self.kind is int:
            kind = "a whole number "
        elif self.kind is float and not _is_number(value):
            kind = "a number "
        elif self.kind is float and not is_finite(value) and not self.endless:
            kind = "a finite number "
        raise UserError(
            f"{where}{self.name}: {shown(value)}: must be {kind}{self.allowed} ({self.meaning})"
        )

    def written(self, value: object, where: str = "") -> Any:
        """Value as a user writes it, with ``AUTO`` for a derived one; errors as `checked`."""
        return None if self.derived and value == AUTO else self.checked(value, where)

    def parsed(self, text: str, where: str = "") -> Any:
        """Value of a text; errors as `checked`."""
        value: object = text
        if self.kind is bool:
            value = SWITCH.get(text, text)
        elif self.kind is not str:
            try:
                value = self.kind(text)
            except ValueError:
                value = text
        return self.written(value, where)


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def is_finite(x: Any) -> bool:
    """Whether a number is below ``LARGEST``."""
    size = abs(x) if isinstance(x, int) else abs(float(x))
    return size < LARGEST


def _is(value: object, choice: str) -> bool:
    """Whether a value is this choice; ``FILE.json`` is any file with that suffix."""
    is_file = choice.startswith("FILE.") and isinstance(value, str) and value.endswith(choice[4:])
    return value == choice or is_file


def number(
    default: Any,
    unit: str,
    low: float,
    high: float,
    meaning: str,
    *,
    above: bool = False,
    endless: bool = False,
) -> Any:
    """Field of a number from ``low`` to ``high``; a field of type int takes whole numbers."""
    setting = Setting("", default, unit, low, high, meaning, above=above, endless=endless)
    return field(default=default, metadata={"setting": setting})


def derived(unit: str, low: float, high: float, meaning: str, *, endless: bool = False) -> Any:
    """Field of a number that follows from the machine unless it is given."""
    setting = Setting("", None, unit, low, high, meaning, kind=float, endless=endless, derived=True)
    return field(default=None, metadata={"setting": setting})


def switch(default: bool, meaning: str) -> Any:
    """Field that is true or false."""
    return word(default, meaning)


def word(
    default: Any,
    meaning: str,
    choices: Mapping[str, str] | None = None,
    *,
    renamed: Mapping[str, str] | None = None,
    was: str = "",
) -> Any:
    """Field of a word: one of ``choices``, or any."""
    setting = Setting(
        "", default, "", 0, 0, meaning, choices=choices or {}, renamed=renamed or {}, was=was
    )
    return field(default=default, metadata={"setting": setting})


@cache
def settings_of(cls: type) -> Mapping[str, Setting]:
    """Settings of a dataclass by name; other fields are left out."""
    return MappingProxyType(
        {
            f.name: dataclasses.replace(
                s := f.metadata["setting"], name=f.name, kind=s.kind if s.derived else f.type
            )
            for f in dataclasses.fields(cls)
            if "setting" in f.metadata
        }
    )


def refuse_old(name: str, known: Mapping[str, Setting], where: str) -> None:
    """Refuse the name of a setting of earlier versions.

    Raises
    ------
    UserError
        Names the setting that took its place, and what it may be.
    """
    for now in known.values():
        if name and name == now.was:
            raise UserError(f"{where}{name}: is now {now.name}: write {now.name}, {now.allowed}")


def check(owner: object, where: str = "") -> None:
    """Check every setting of an instance, and make it of its kind; errors as `Setting.checked`."""
    cls: type = type(owner)
    for setting in settings_of(cls).values():
        value = setting.checked(getattr(owner, setting.name), where)
        object.__setattr__(owner, setting.name, value)


def read(cls: type, values: Mapping[str, object], where: str) -> dict[str, Any]:
    """Settings of a dataclass from a table that a user wrote.

    Raises
    ------
    UserError
        A name is unknown, outdated or missing, or as `Setting.checked`.
    """
    known = settings_of(cls)
    unknown = sorted(set(values) - set(known))
    if unknown:
        refuse_old(unknown[0], known, where)
        raise UserError(f"{where}{unknown[0]}: unknown: use only {', '.join(known)}")
    for name, setting in known.items():
        if name not in values and setting.default is REQUIRED:
            raise UserError(f"{where}{name}: missing: give {setting.meaning}, {setting.allowed}")
    return {n: s.written(values[n], where) for n, s in known.items() if n in values}

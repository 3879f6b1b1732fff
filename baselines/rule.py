"""What a hand-over rule tells about itself: its name, its parameters, and how to build it."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policy import Policy

Values = Mapping[str, float]
"""Parameters by name. They hold no property of a machine: speeds are shares of rated speed."""

SPEED_UNIT = "r/min"
"""Unit of parameters that a user gives in r/min and that rules get as a share of rated speed."""


@dataclass(frozen=True)
class Parameter:
    """One number of a rule. All bounds and the default are as the rule gets them."""

    name: str
    default: float
    low: float
    """Lower end of the range that tuning searches."""
    high: float
    unit: str
    """Of the number on the command line."""
    doc: str
    least: float = 0.0
    """Lower end of what is allowed at all."""
    most: float = math.inf

    def factor(self, motor: Motor) -> float:
        """Number on the command line over the number that the rule gets."""
        return motor.n_rated_rpm if self.unit == SPEED_UNIT else 1.0


def speed(name: str, default: float, low: float, high: float, doc: str) -> Parameter:
    """Speed, a share of rated speed; r/min on the command line."""
    return Parameter(name, default, low, high, SPEED_UNIT, doc, most=10.0)


@dataclass(frozen=True)
class Rule:
    """A hand-over rule by name."""

    name: str
    doc: str
    """One line."""
    build: Callable[[str, Values, Motor], Policy]
    """From the policy's name, its parameters and the machine."""
    parameters: tuple[Parameter, ...] = ()
    rising: tuple[tuple[str, str], ...] = ()
    """Pairs of parameters of which the first has to be below the second."""
    needs_numbers: bool = False
    """There are no defaults worth having."""

    @property
    def usage(self) -> str:
        """Word for the command line, with the names of the parameters in capitals."""
        names = [p.name.upper() for p in self.parameters]
        if len(names) > 8:
            names = [*names[:2], "...", names[-1]]
        text = f":{','.join(names)}" if names else ""
        return self.name + (text if self.needs_numbers or not text else f"[{text}]")

    def defaults(self) -> dict[str, float]:
        """Every parameter at its default."""
        return {p.name: p.default for p in self.parameters}

    def allows(self, values: Values) -> bool:
        """Every number is finite, in its range, and in order with the others."""
        return all(p.least <= values[p.name] <= p.most for p in self.parameters) and all(
            values[low] < values[high] for low, high in self.rising
        )

    def parse(self, spec: str, text: str | None, motor: Motor) -> dict[str, float]:
        """Parameters from the text behind the colon, as the rule gets them.

        Parameters
        ----------
        spec : str
            The whole word, for the message.
        text : str or None
            All parameters in order, or NAME=VALUE for some of them; None for the defaults.
        motor : Motor

        Raises
        ------
        UserError
            Too few or too many numbers, an unknown name, or numbers out of their range.
        """
        if text is None and not self.needs_numbers:
            return self.defaults()
        if not self.parameters:
            raise UserError(f"policy: {spec!r}; allowed: {self.name} without numbers")
        words = (text or "").split(",")
        names = [p.name for p in self.parameters]
        pairs = [w.split("=", 1) for w in words]
        if all(len(pair) == 2 for pair in pairs):
            given = {name.strip().lower(): number for name, number in pairs}
            good = set(given) <= set(names) and len(given) == len(words)
        else:
            given = dict(zip(names, words, strict=False))
            good = len(words) == len(names)
        values = self.defaults()
        for p in self.parameters:
            if p.name in given:
                values[p.name] = _number(given[p.name]) / p.factor(motor)
        if not good or not self.allows(values):
            raise UserError(f"policy: {spec!r}; allowed: {self.usage} with {self._ranges(motor)}")
        return values

    def spec(self, values: Values, motor: Motor) -> str:
        """Word for the command line that gives these parameters on this machine."""
        numbers = (f"{values[p.name] * p.factor(motor):.6g}" for p in self.parameters)
        return ":".join(filter(None, (self.name, ",".join(numbers))))

    def _ranges(self, motor: Motor) -> str:
        texts = [f"{low.upper()} < {high.upper()}" for low, high in self.rising]
        for p in self.parameters[: 8 if len(self.parameters) > 8 else None]:
            least, most = p.least * p.factor(motor), p.most * p.factor(motor)
            top = f" to {most:g}" if math.isfinite(most) else " or more"
            unit = "" if p.unit == "1" else f" {p.unit}"
            texts.append(f"{p.name.upper()} from {least:g}{top}{unit}")
        return ", ".join(texts)


def _number(text: str) -> float:
    """NaN for what is no finite number: it is in no range."""
    try:
        x = float(text)
    except ValueError:
        return math.nan
    return x if math.isfinite(x) else math.nan

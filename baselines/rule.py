"""What defines a hand-over rule: its name, its parameters, and how to build it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policy import Policy
from sensorless.settings import Setting

Values = Mapping[str, float]
"""Parameters by name, free of any machine: speeds are shares of rated speed."""


@dataclass(frozen=True)
class Parameter(Setting):
    """One number of a rule. Range and default are as the rule gets them, the unit as users do."""

    search: tuple[float, float] = field(kw_only=True)
    """Range that tuning searches."""
    is_speed: bool = field(default=False, kw_only=True)
    """Rules get it as a share of rated speed, users give it in r/min."""
    on: Callable[[Motor], float] | None = field(default=None, kw_only=True)
    """Default on a machine, if it follows from the machine."""

    def factor(self, motor: Motor) -> float:
        """Number on the command line over the number that the rule gets."""
        return motor.n_rated_rpm if self.is_speed else 1.0

    def parsed_on(self, motor: Motor, text: str, where: str) -> float:
        """Number that the rule gets, from the text on the command line; errors as `parsed`."""
        factor = self.factor(motor)
        told = replace(self, low=factor * self.low, high=factor * self.high)
        return float(told.parsed(text, where)) / factor


def speed(
    name: str,
    default: float,
    search: tuple[float, float],
    meaning: str,
    *,
    low: float = 0.0,
    on: Callable[[Motor], float] | None = None,
) -> Parameter:
    """Speed, a share of rated speed from ``low`` to 10; r/min on the command line."""
    return Parameter(name, default, "r/min", low, 10, meaning, search=search, is_speed=True, on=on)


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
    estimator: str | None = None
    """Estimator that the rule brings along, in its policy's ``settings``."""

    @property
    def usage(self) -> str:
        """Word for the command line, with the names of the parameters in capitals."""
        names = [p.name.upper() for p in self.parameters]
        if len(names) > 8:
            names = [*names[:2], "...", names[-1]]
        text = f":{','.join(names)}" if names else ""
        return self.name + (text if self.needs_numbers or not text else f"[{text}]")

    def defaults(self, motor: Motor | None = None) -> dict[str, float]:
        """Every parameter at its default on a machine; None: on one like the paper's."""
        return {
            p.name: p.default if motor is None or p.on is None else p.on(motor)
            for p in self.parameters
        }

    def allows(self, values: Values) -> bool:
        """Every number is finite, in its range, and in order with the others."""
        return all(p.holds(values[p.name]) for p in self.parameters) and all(
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
            return self.defaults(motor)
        where = f"policy {spec!r}: "
        if not self.parameters:
            raise UserError(f"{where}{self.name} takes no numbers: write {self.name}")
        words = (text or "").split(",")
        names = [p.name for p in self.parameters]
        pairs = [w.split("=", 1) for w in words]
        if all(len(pair) == 2 for pair in pairs):
            given = {name.strip().lower(): number for name, number in pairs}
            good = set(given) <= set(names) and len(given) == len(words)
        else:
            given = dict(zip(names, words, strict=False))
            good = len(words) == len(names)
        if not good:
            n = len(names)
            some = f"all {n} numbers in order, or some as NAME=VALUE" if n > 1 else "one number"
            raise UserError(f"{where}give {some}: {self.usage}")
        values = self.defaults(motor)
        for p in self.parameters:
            if p.name in given:
                values[p.name] = p.parsed_on(motor, given[p.name], where)
        for low, high in self.rising:
            if not values[low] < values[high]:
                raise UserError(f"{where}{low.upper()} must be below {high.upper()}: {self.usage}")
        return values

    def spec(self, values: Values, motor: Motor) -> str:
        """Word for the command line that gives these parameters on this machine."""
        numbers = (f"{values[p.name] * p.factor(motor):.6g}" for p in self.parameters)
        return ":".join(filter(None, (self.name, ",".join(numbers))))

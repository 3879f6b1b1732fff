"""Fuzzy schedule: a Takagi-Sugeno rule base over speed, acceleration and disagreement.

The source paper calls its schedule fuzzy but prints a linear ramp and no rule base; this rule base
is ours. Its triangular terms add up to 1 and AND is the product, so it is multilinear between the
peaks of the terms: a table with its nodes at the peaks *is* the system (but for rounding, below
1e-6). simpful evaluates it once per process (doi 10.2991/ijcis.d.201012.002).

Why these rules: stay on the injection at low speed; hand over early when speeding up, and late when
slowing down, because the injection will soon be needed; hand over late when the estimators
disagree, because at these speeds voltage errors hurt the observer more than cross-coupling hurts
the injection.
"""

from contextlib import redirect_stdout
from functools import lru_cache
from io import StringIO
from itertools import product
from math import inf

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.rule import Parameter, Rule, Values, speed
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable

TERMS = {
    "speed": ("slow", "low", "high", "fast"),
    "acceleration": ("braking", "steady", "speeding"),
    "disagreement": ("negative", "small", "positive"),
}
"""Names of the terms; their peaks are evenly spaced over the range of the variable."""

LEVELS = {
    "all": 1.0,
    "most": 0.85,
    "more": 0.65,
    "half": 0.5,
    "less": 0.3,
    "little": 0.12,
    "none": 0,
}
"""Share of the injection."""

RULES = (
    "IF (speed IS slow) THEN (k_s IS all)",
    "IF (speed IS low) AND (NOT (disagreement IS small)) THEN (k_s IS all)",
    "IF (speed IS low) AND (disagreement IS small) AND (acceleration IS braking)"
    " THEN (k_s IS most)",
    "IF (speed IS low) AND (disagreement IS small) AND (acceleration IS steady) THEN (k_s IS more)",
    "IF (speed IS low) AND (disagreement IS small) AND (acceleration IS speeding)"
    " THEN (k_s IS half)",
    "IF (speed IS high) AND (NOT (disagreement IS small)) THEN (k_s IS half)",
    "IF (speed IS high) AND (disagreement IS small) AND (acceleration IS braking)"
    " THEN (k_s IS half)",
    "IF (speed IS high) AND (disagreement IS small) AND (acceleration IS steady)"
    " THEN (k_s IS less)",
    "IF (speed IS high) AND (disagreement IS small) AND (acceleration IS speeding)"
    " THEN (k_s IS little)",
    "IF (speed IS fast) THEN (k_s IS none)",
)
"""Complete and without overlap: at every input the weights of all rules add up to 1."""


class FuzzySystem:
    """The rule base over three variables from 0 to 1, evaluated by the library.

    Raises
    ------
    UserError
        The library is not installed.
    """

    def __init__(self) -> None:
        try:
            import simpful
        except ImportError:
            raise UserError(
                "policy: 'fuzzy' needs the library simpful; run: pip install 'sensorless[fuzzy]'"
            ) from None
        self._system = simpful.FuzzySystem(
            operators=["AND_PRODUCT"], show_banner=False, verbose=False
        )
        for name, terms in TERMS.items():
            sets = simpful.AutoTriangle(len(terms), terms=list(terms))
            self._system.add_linguistic_variable(name, sets)
        with redirect_stdout(StringIO()):  # the library prints which kind of system it found
            for name, level in LEVELS.items():
                self._system.set_crisp_output_value(name, level)
            self._system.add_rules(list(RULES))

    def __call__(self, speed: float, acceleration: float, disagreement: float) -> float:
        """k_s at one point of the unit cube."""
        self._system.set_variable("speed", speed)
        self._system.set_variable("acceleration", acceleration)
        self._system.set_variable("disagreement", disagreement)
        return float(self._system.Sugeno_inference(["k_s"])["k_s"])


@lru_cache(maxsize=1)
def peak_values() -> NDArray[np.float32]:
    """k_s where one term of each variable has its peak (4, 3, 3)."""
    system = FuzzySystem()
    shape = tuple(len(terms) for terms in TERMS.values())
    peaks = [np.linspace(0.0, 1.0, n).tolist() for n in shape]
    values = np.array([system(*at) for at in product(*peaks)])
    out: NDArray[np.float32] = np.clip(values, 0.0, 1.0).astype(np.float32).reshape(shape)
    return out


def fuzzy_table(low: float, high: float, acceleration: float, disagreement: float) -> KsTable:
    """Table of the rule base.

    Parameters
    ----------
    low, high : float
        Peaks of the terms slow and fast over rated speed [-].
    acceleration : float
        Peak of the term speeding, minus that of braking [rated speed per second].
    disagreement : float
        Peak of the term positive, minus that of negative [30 degrees].
    """
    axes = (
        Axis("speed", low, high, 4),
        Axis("acceleration", -acceleration, acceleration, 3),
        Axis("disagreement", -disagreement, disagreement, 3),
    )
    return KsTable(axes, peak_values())


def _build(name: str, v: Values, motor: Motor) -> TablePolicy:
    table = fuzzy_table(v["lo"], v["hi"], v["acceleration"], v["disagreement"] / 30.0)
    return TablePolicy(name, table)


RULE = Rule(
    "fuzzy",
    "ten fuzzy rules over speed, acceleration and disagreement",
    _build,
    (
        speed("lo", 0.1, (0.0, 0.5), "peak of the term slow"),
        speed("hi", 0.4, (0.1, 1.5), "peak of the term fast"),
        Parameter(
            "acceleration",
            3.0,
            "1/s",
            0.001,
            inf,
            "peak of speeding up over rated speed",
            search=(0.3, 20.0),
        ),
        Parameter(
            "disagreement", 20.0, "deg", 0.001, inf, "peak of disagreement", search=(3.0, 90.0)
        ),
    ),
    rising=(("lo", "hi"),),
)

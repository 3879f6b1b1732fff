"""Linear ramp of the estimated speed: the rule of the source paper.

    k_s = 1                                     |omega_hat| <= low
    k_s = (high - |omega_hat|) / (high - low)   low <= |omega_hat| <= high
    k_s = 0                                     high <= |omega_hat|

This is Eq. 25 of doi 10.12177/emca.2025.011 with what the print lacks: the magnitude (as printed,
every negative speed gives k_s = 1) and the cases of equality. The paper gives the band of its own
motor alone; on others it begins at the same share of rated speed, and ends at the same or later.
"""

from collections.abc import Callable

import numpy as np

from sensorless.baselines.rule import Parameter, Rule, Values, speed
from sensorless.machine.motor import Motor
from sensorless.observers.hand_over import unaided_speed
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable

EQ25_BAND = (300.0 / 1500.0, 400.0 / 1500.0)
"""The paper's band, 300 to 400 r/min, as shares of its motor's rated speed."""


def eq25_band(motor: Motor) -> tuple[float, float]:
    """Band of Eq. 25 on a machine, over rated speed [-].

    The paper's, or up to ``unaided_speed`` where resistance and dead time take so much of the EMF
    that a drive without injection leans too far at the end of the paper's; at most to rated speed.
    """
    low, high = EQ25_BAND
    try:
        alone = unaided_speed(motor) / motor.omega_rated
    except (ArithmeticError, ValueError):  # no file may have such numbers: the drive says which
        return low, high
    return low, min(max(high, alone), 1.0)


def eq25_end(motor: Motor) -> float:
    """Speed, over rated, from which Eq. 25 leaves a machine to the observer [-]."""
    return eq25_band(motor)[1]


def band(above: str) -> tuple[Parameter, Parameter]:
    """Parameters of a rule that leaves injection over a band of the speed, by default Eq. 25's.

    ``above``: what holds above the band, for the help.
    """
    return (
        speed("lo", EQ25_BAND[0], (0.0, 0.6), "below it injection alone"),
        speed("hi", EQ25_BAND[1], (0.05, 1.5), above, on=eq25_end),
    )


def linear_table(low: float, high: float) -> KsTable:
    """Table of two nodes on the speed axis: exactly the ramp, because a table is constant outside.

    Parameters
    ----------
    low, high : float
        Band over rated speed [-], low < high.
    """
    return KsTable((Axis("speed", low, high, 2),), np.array([1.0, 0.0], dtype=np.float32))


def on_a_band(name: str, doc: str, table: Callable[[float, float], KsTable]) -> Rule:
    """Rule with the two ends of its band as parameters."""

    def build(word: str, v: Values, motor: Motor) -> TablePolicy:
        return TablePolicy(word, table(v["lo"], v["hi"]))

    return Rule(name, doc, build, band("above it the observer alone"), rising=(("lo", "hi"),))


EQ25 = Rule(
    "eq25",
    "linear ramp of the paper, 20 to 26.7 % of rated speed (300 to 400 r/min there), or more",
    lambda name, v, motor: TablePolicy(name, linear_table(*eq25_band(motor))),
)
RULE = on_a_band(
    "linear",
    "linear ramp, 1 at a speed of LO to 0 at HI [r/min]; the band of eq25 by default",
    linear_table,
)

"""Rules that bring their own estimator: the ramp of the speed, with another way to the angle."""

from sensorless.baselines.linear import band, linear_table
from sensorless.baselines.rule import Rule, Values
from sensorless.machine.motor import Motor
from sensorless.policy import TablePolicy


def ramp_on(name: str, estimator: str, doc: str) -> Rule:
    """Rule ``name`` with the ends of its band as parameters, by default those of Eq. 25."""

    def build(word: str, v: Values, motor: Motor) -> TablePolicy:
        return TablePolicy(word, linear_table(v["lo"], v["hi"]), {"estimator": estimator})

    ends = band("above it no injection")
    return Rule(name, doc, build, ends, rising=(("lo", "hi"),), estimator=estimator)


SLIDING_MODE = ramp_on(
    "sliding_mode",
    "smo",
    "the paper's rule on the paper's observers: ramp of the speed to the sliding-mode one",
)
ERROR_BLEND = ramp_on(
    "error_blend",
    "errors",
    "ramp of the speed, but k_s weighs two error signals in one loop instead of two angles",
)
FLUX_OBSERVER = ramp_on(
    "flux_observer",
    "flux",
    "ramp of the speed from injection to a flux observer instead of the sliding-mode one",
)

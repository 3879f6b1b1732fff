"""A machine examined on paper: all that its numbers show without running a drive."""

from dataclasses import dataclass

from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import RatedPoint, rated_point
from sensorless.machine.sane import insane
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding, Verdict, verdict
from sensorless.suitability.plausible import plausible
from sensorless.suitability.seen import Seen, look, low_trip, objections, suggestions, unmeasured

OTHER_MACHINE = 2.0
"""Torque of rated current over rated torque, above which the numbers are not of one machine."""


@dataclass(frozen=True)
class Examination:
    """Result of an examination; the parts are None where the numbers allow none."""

    motor: Motor
    findings: tuple[Finding, ...]
    point: RatedPoint | None = None
    seen: Seen | None = None
    suggested: dict[str, float] | None = None

    @property
    def verdict(self) -> Verdict:
        """Verdict of the findings."""
        return verdict(self.findings)


def examine(motor: Motor, pll_hz: float) -> Examination:
    """Plausibility, rated point, saliency and signal of a machine.

    Parameters
    ----------
    pll_hz : float
        Natural frequency of the injection loop [Hz].
    """
    found: list[Finding] = []
    try:
        for finding in plausible(motor):
            found.append(finding)
        if any(insane(motor)):
            return Examination(motor, tuple(found))
        point = rated_point(motor)
        seen = look(motor, pll_hz)
    except UserError as error:
        return Examination(motor, (*found, Finding(NO, "saturation", str(error))))
    objection = point.objection(motor)
    if objection is not None:
        found.append(Finding(LIMIT if point.torque_at_speed > 0.0 else NO, "rating", objection))
    spare = point.spare(motor)
    if spare is not None:
        other = point.torque > OTHER_MACHINE * motor.tau_rated
        found.append(Finding(LIMIT if other else NOTE, "tau_rated", spare))
    salient = motor.L_q > motor.L_d
    found += (*objections(motor, seen, point.current), *unmeasured(seen)) if salient else ()
    suggested = suggestions(motor, seen, pll_hz) if salient else None
    found += low_trip(motor, suggested) if suggested else ()
    return Examination(motor, tuple(found), point, seen, suggested)

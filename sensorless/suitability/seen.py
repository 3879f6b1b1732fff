"""What injection can see with this flux map and these sensors, and settings to choose."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sensorless.machine.magnetics import Floats, cross_angle
from sensorless.machine.motor import Motor
from sensorless.observers.injection_signal import (
    RIPPLE_SHARE,
    InjectionSignal,
    injection_signal,
    suggested_injection,
)
from sensorless.observers.q_inductance import lean
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding
from sensorless.suitability.plausible import ROUNDING, TURN
from sensorless.suitability.restoring import pulled_back

RATIO = (1.3, 1.05)
"""Inductance ratio under load below which errors of the machine's parameters may lose the rotor, or
injection gets no useful signal."""
IRON_TAKES = 0.2
"""Share of L_q that iron commonly takes at rated current; a larger margin is not worth a word."""
NOISE = (3.0, 10.0)
"""RMS angle noise above which the drive is limited, or unable [deg]."""
CROSS = (25.0, 40.0)
"""Turn of the magnetic axes above which the drive is limited, or unable [deg].

Compensation has to be exact to a fraction of it."""

PULLED = 0.2
"""Share of an error of up to 20 degrees that injection sees, below which the drive is limited.
Shipped and 512 random machines have 0.4 or more up to ``i_max``; a reluctance machine with magnets
lost none of 200 ``reversal`` with 0.01, 6 % with -0.07 and 21 % with -0.44."""
LEAN = 1.3
"""Lean of the EMF at rated current above which the drive is limited: shipped and random machines
have 1.25 or less, and one of 1.44 lost 15 % of ``nominal`` though its file was exact."""


@dataclass(frozen=True)
class Seen:
    """What injection sees along the operating line."""

    signal: InjectionSignal
    cross_deg: Floats
    """(n,) turn of the magnetic axes [deg]"""
    pulled: Floats
    """(n,) least share of an error of up to 20 degrees that injection sees"""
    rated: int
    """index of the last current within rated"""


def look(motor: Motor, pll_hz: float) -> Seen:
    """Signal, saliency and cross-coupling from zero current to ``i_max``."""
    signal = injection_signal(motor, pll_hz)
    size = np.hypot(*signal.i.T)
    last = int(np.flatnonzero(size <= (1.0 + 1e-9) * motor.i_rated)[-1])
    return Seen(
        signal, np.rad2deg(cross_angle(motor, signal.i)), pulled_back(motor, signal.i), last
    )


def objections(motor: Motor, seen: Seen, needed: float) -> Iterator[Finding]:
    """Limits of injection within rated current and up to ``i_max``.

    ``needed``: least current of rated torque [A].
    """
    s, size = seen.signal, np.hypot(*seen.signal.i.T)
    for field, values, (limit, bad), unit, what in (
        ("L_q", -s.ratio, (-RATIO[0], -RATIO[1]), "", "inductance ratio"),
        ("u_inj", s.noise_deg, NOISE, " degrees", "angle noise of injection"),
        ("saturation", np.abs(seen.cross_deg), CROSS, " degrees", "turn by cross-coupling"),
    ):
        limit += ROUNDING * abs(limit)
        worst = float(values[: seen.rated + 1].max())
        beyond = np.flatnonzero(values > limit)
        if not len(beyond):
            continue
        upto = float(size[max(beyond[0] - 1, 0)])
        weight = NO if worst > bad else LIMIT
        cure = ": lower i_max"
        if upto < needed:
            cure = ", less than rated torque needs: rate the machine for less"
        where = "within rated current" if worst > limit else f"above {upto:.3g} A{cure}"
        top = worst if worst > limit else float(values.max())
        bound = "at least" if field == "L_q" else "at most"
        text = f"{what} {abs(top):.3g}{unit} {where}; needed: {bound} {abs(limit):.3g}"
        if weight == NO:
            text += f"; {'below' if field == 'L_q' else 'beyond'} {abs(bad):g} the answer is no"
        if field == "L_q" and weight == LIMIT:
            text += ", or errors of L_d, L_q and iron may lose the rotor unnoticed"
        yield Finding(weight, field, text)
    least = float(seen.pulled.min())
    if least < PULLED:
        upto = float(size[max(int(np.argmax(seen.pulled < PULLED)) - 1, 0)])
        text = (
            f"above {upto:.3g} A injection sees {max(least, 0.0):.2g} of an angle error of up to "
        )
        text += f"20 degrees (needed: at least {PULLED:g}), and a disturbed angle may not come back"
        yield Finding(LIMIT, "i_max", text + ": lower i_max")
    leans = lean(motor)
    if leans > LEAN:
        turned = np.degrees(np.arctan(0.1 * leans))
        text = (
            f"L_q i_q at rated current is {leans:.3g} times the flux of the EMF (needed: at most "
        )
        text += f"{LEAN:g}), so a tenth of error in L_q leans its angle by {turned:.0f} degrees: "
        text += "rate the machine for less current"
        yield Finding(LIMIT, "L_q", text)
    if s.amplitude > 2.5 * RIPPLE_SHARE * motor.i_rated:
        text = f"injected current {s.amplitude:.3g} A is {s.amplitude / motor.i_rated:.0%} of rated"
        yield Finding(LIMIT, "u_inj", text)


def unmeasured(seen: Seen) -> Iterator[Finding]:
    """A note if the ratio is little above its limit and the same at any current: not measured."""
    ratio = seen.signal.ratio
    least = float(ratio.min())
    left = 1.0 - RATIO[0] / least
    if np.ptp(ratio) < 1e-6 * least and 0.0 < left < IRON_TAKES:
        text = (
            f"L_q/L_d is {least:.3g} at any current, since the file has no saturation: where iron "
        )
        text += f"takes {left:.0%} of L_q, it is below {RATIO[0]:g}; measure it under load "
        yield Finding(NOTE, "L_q", text + "(sensorless identify machine)")


def suggestions(motor: Motor, seen: Seen, pll_hz: float) -> dict[str, float]:
    """Suggested values of ``u_inj``, ``i_trip``, ``adc_range`` and ``T_s``.

    The trip is above the limit by the injected current and its rise in two periods, until control
    reacts; twice the limit is enough. The converter measures what control may reach, the limit with
    the injected current on top: to trip belongs to hardware. An electrical turn at rated speed has
    at least ``TURN[0]`` periods.
    """
    u_inj = suggested_injection(motor, pll_hz)
    ripple = seen.signal.amplitude * u_inj / motor.u_inj
    small = float(np.min(0.5 * motor.u_inj * motor.T_s / seen.signal.amplitude))
    rise = 2.0 * (2.0 / 3.0) * motor.u_dc * motor.T_s / small
    return {
        "u_inj": u_inj,
        "i_trip": _two(min(motor.i_max + ripple + rise, 2.0 * motor.i_max)),
        "adc_range": _two(1.15 * (motor.i_max + ripple)),
        "T_s": min(motor.T_s, _two(2.0 * np.pi / (TURN[0] * motor.omega_rated))),
    }


def near(value: float, suggested: float) -> bool:
    """Whether a value is the suggested one in two digits."""
    return _two(value) == _two(suggested)


def reaches(value: float, least: float) -> bool:
    """Whether a value is as large as the least that is suggested, both in two digits."""
    return _two(value) >= least


def low_trip(motor: Motor, suggested: dict[str, float]) -> Iterator[Finding]:
    """A note if ``i_trip`` is below what is suggested, both in two digits."""
    least = suggested["i_trip"]
    if not reaches(motor.i_trip, least):
        text = f"i_trip = {motor.i_trip:g} A is below {least:g} A, which the current may reach "
        text += "from i_max before control reacts: such a swing trips"
        yield Finding(NOTE, "i_trip", text)


def _two(value: float) -> float:
    return float(f"{value:.2g}")

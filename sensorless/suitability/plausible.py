"""Numbers of a motor file in per-unit terms, where wrong units, factors and axes show."""

import math
from collections.abc import Iterator

import numpy as np

from sensorless.errors import UserError
from sensorless.machine.inverter import threshold_voltage
from sensorless.machine.magnetics import currents, flux, plant_currents
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import polar
from sensorless.machine.saliency import LEAST, principal
from sensorless.machine.sane import insane
from sensorless.observers.injection_signal import LINK_SHARE
from sensorless.observers.tracking import MOST_DEAD_TIME
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding

BEYOND = 3.0
"""A value this factor outside its usual range is an error, not an unusual machine."""
BEYOND_J = 100.0
"""The same of the start time, which a flywheel makes long."""
ROUNDING = 1e-6
"""Relative difference of a value from its bound that counts as none."""
MUCH_R_S = 0.2
"""Voltage of rated current in R_s over the EMF at rated speed from which on a winding that is
warmer than the file's costs speed and lock."""
AT_SPEED = ("psi_f", "L_d", "L_q")
"""Numbers whose voltage is that at rated speed."""
TURN = (20.0, 8.0)
"""PWM periods per electrical turn at rated speed below which a drive is limited, or unable."""
SAME = 0.05
"""Largest relative difference of [saturation] at zero current from L_d, L_q and psi_f."""
OTHER = 2.5
"""Factor between the same from which on they describe two machines."""
LEAST_LIMIT, MOST_TRIP = 0.1, 10.0
"""Least i_max over rated current that turns the shaft; largest i_trip over i_max that protects."""
MUCH_IRON = (0.1, 0.5)
"""Iron loss at rated speed over rated power, above which it is unusual, or no machine."""

MUCH_FRICTION = 0.2
"""Friction at rated speed over rated torque, above which it is hardly the machine's own."""


def plausible(motor: Motor) -> Iterator[Finding]:
    """Implausible numbers, each alone and in relation to the others."""
    found = [*_per_unit(motor), *_axes(motor)]
    yield from found
    if beyond := list(insane(motor)):  # nothing to compute with
        said = {f.field for f in found}
        yield from (Finding(NO, field, text) for field, text in beyond if field not in said)
        return
    yield from _saturation(motor)
    yield from _correction(motor)
    yield from _resistance(motor)
    yield from _pulses(motor)
    yield from _limits(motor)
    yield from _injection(motor)
    yield from _losses(motor)


def require_plausible(motor: Motor) -> None:
    """Refuse a machine whose numbers contradict each other.

    Raises
    ------
    UserError
        Names the machine, the first field that is wrong, and its value.
    """
    for finding in plausible(motor):
        if finding.weight == NO:
            raise UserError(
                f"motor {motor.name!r}: {finding.text}; correct the motor file: sensorless motor "
                "check shows all that is wrong"
            )


def _per_unit(m: Motor) -> Iterator[Finding]:
    """Base values: u_dc / sqrt(3), rated current, rated speed.

    The usual ranges hold what the shipped and 500 random machines have, with a factor of 1.6 to 33
    to spare: beyond, a wrong unit is likelier than such a machine.
    """
    u, w = m.u_dc / math.sqrt(3.0), m.omega_rated
    z = u / m.i_rated
    start = m.J * w / m.n_p / m.tau_rated
    # magnet and iron, each at its best angle: above what both make together
    most = 1.5 * m.n_p * m.i_rated * (m.psi_f + 0.5 * abs(m.L_q - m.L_d) * m.i_rated)
    drop = "voltage that rated current drops across {}{} over the DC link's"
    found = {
        field: (value, low, high, what)
        for field, value, low, high, what in (
            ("psi_f", w * m.psi_f / u, 0.1, 1.6, "no-load EMF at rated speed over the DC link's"),
            ("R_s", m.R_s / z, 3e-4, 0.25, drop.format("R_s", "")),
            ("L_d", w * m.L_d / z, 0.02, 1.5, drop.format("L_d", " at rated speed")),
            ("L_q", w * m.L_q / z, 0.03, 4.0, drop.format("L_q", " at rated speed")),
            ("tau_rated", m.tau_rated / most, 0.05, 2.0, "rated torque over that of rated current"),
            ("J", start, 0.004, 15.0, "seconds from rest to rated speed at rated torque"),
        )
        if not low <= value <= high
    }  # fmt: skip
    if found.keys() >= set(AT_SPEED):
        shared = [found[field] for field in AT_SPEED]
        sides = {value > high for value, _, high, _ in shared}
        if len(sides) == 1:  # what they share is wrong
            found = {field: found[field] for field in found if field not in AT_SPEED}
            yield Finding(
                NO if any(_far(*x[:3]) for x in shared) else LIMIT,
                "u_dc",
                f"u_dc = {m.u_dc:g} V, n_rated_rpm = {m.n_rated_rpm:g}: no-load EMF, and rated "
                f"current in L_d and L_q, take {', '.join(f'{x[0]:.3g}' for x in shared)} times "
                f"the DC link's voltage, all too {'much' if sides == {True} else 'little'}: wrong "
                "DC link, rated speed or pole pairs?",
            )
    for field, (value, low, high, what) in found.items():
        yield Finding(
            NO if _far(value, low, high, BEYOND_J if field == "J" else BEYOND) else LIMIT,
            field,
            f"{field} = {getattr(m, field):g}: {what} is {value:.3g}, usually {low:g} to {high:g}: "
            f"wrong unit, factor{', rated speed' if field in AT_SPEED else ''} or pole pairs?",
        )


def _far(value: float, low: float, high: float, beyond: float = BEYOND) -> bool:
    """Whether a value is so far outside that no machine has it."""
    return max(low / value, value / high) > beyond


def _axes(m: Motor) -> Iterator[Finding]:
    if m.L_d > LEAST * m.L_q:
        yield Finding(NO, "L_q", f"L_d = {m.L_d:g} H is above L_q = {m.L_q:g} H: swapped?")
    elif m.L_q < LEAST * m.L_d:
        text = f"no saliency: L_d = {m.L_d:g} H, L_q = {m.L_q:g} H give injection no angle"
        yield Finding(NO, "L_q", text)


def _saturation(m: Motor) -> Iterator[Finding]:
    zero = np.zeros((1, 2))
    L_d, L_q = sorted(principal(m, zero)[0], reverse=m.L_d > m.L_q)
    found = {"L_d": L_d, "L_q": L_q, "psi_f": flux(m.saturation, zero)[0, 0]}
    for field, value in found.items():
        said = getattr(m, field)
        if abs(value / said - 1.0) <= SAME:
            continue
        text = f"[saturation] gives {field} = {value:.4g} at zero current, but the file says "
        if 1.0 / OTHER <= value / said <= OTHER:
            yield Finding(LIMIT, field, f"{text}{said:g}")
        elif field == "psi_f" and m.saturation.i_f == 0.0:
            text = f"[saturation] has no magnet, i_f = 0, but the file says psi_f = {said:g}: "
            yield Finding(NO, field, text + "give i_f, the magnet current")
        else:
            yield Finding(NO, field, f"{text}{said:g}: another machine, or a wrong unit?")


def _correction(m: Motor) -> Iterator[Finding]:
    if m.flux_correction is None:
        return
    i = polar(m)
    beyond = plant_currents(m, psi := flux(m.saturation, i)) - currents(m.saturation, psi)
    most = 100.0 * float(np.abs(beyond[np.hypot(*i.T) <= m.i_rated]).max()) / m.i_rated
    yield Finding(
        NOTE,
        "flux_correction",
        f"the simulated machine differs from [saturation], on which the drive is designed, by up "
        f"to {most:.2g} % of rated current within it; this table knows the latter alone",
    )


def _resistance(m: Motor) -> Iterator[Finding]:
    share = m.R_s * m.i_rated / (m.omega_rated * m.psi_f)
    if share >= MUCH_R_S:
        text = f"rated current in R_s = {m.R_s:g} ohm takes {share:.0%} of the EMF at rated speed: "
        text += "a winding much warmer than that may lose speed and rotor; give the warm motor's"
        yield Finding(NOTE, "R_s", text)


def _pulses(m: Motor) -> Iterator[Finding]:
    turn = 2.0 * math.pi / (m.omega_rated * m.T_s)
    if turn < TURN[0] * (1.0 - ROUNDING):
        weight = NO if turn < TURN[1] else LIMIT
        text = f"rated speed has {turn:.4g} PWM periods per electrical turn; needed: {TURN[0]:g}"
        yield Finding(weight, "T_s", text)
    if m.dead_time > 0.1 * m.T_s:
        weight = NO if m.dead_time > 0.5 * m.T_s else LIMIT
        text = f"dead_time = {m.dead_time:g} s is {m.dead_time / m.T_s:.0%} of T_s"
        yield Finding(weight, "dead_time", text + (": wrong unit?" if weight == NO else ""))


def _limits(m: Motor) -> Iterator[Finding]:
    if m.i_max < LEAST_LIMIT * m.i_rated:
        text = f"i_max = {m.i_max:g} A is {m.i_max / m.i_rated:.2g} of i_rated = {m.i_rated:g} A"
        yield Finding(NO, "i_max", f"{text}, too little to turn the shaft: wrong unit?")
    elif m.i_max < m.i_rated:
        text = f"i_max = {m.i_max:g} A is below i_rated = {m.i_rated:g} A"
        yield Finding(LIMIT, "i_max", text)
    if m.i_max > m.adc_range:
        text = f"i_max = {m.i_max:g} A is above what the converter measures, {m.adc_range:g} A"
        yield Finding(NO, "adc_range", text)
    if m.i_trip > MOST_TRIP * m.i_max:
        text = f"i_trip = {m.i_trip:g} A is above {MOST_TRIP:g} times i_max = {m.i_max:g} A"
        yield Finding(LIMIT, "i_trip", f"{text} and protects nothing: wrong unit?")
    elif m.i_trip > m.adc_range:
        text = f"i_trip = {m.i_trip:g} A is above adc_range = {m.adc_range:g} A: trip in hardware"
        yield Finding(NOTE, "i_trip", text)
    if m.psi_f > m.L_d * m.i_trip:
        text = f"a shorted motor that spins drives about psi_f / L_d = {m.psi_f / m.L_d:.4g} A, "
        text += f"above i_trip = {m.i_trip:g} A; zero voltage shorts it: open the bridge to stop"
        yield Finding(NOTE, "i_trip", text)


def _injection(m: Motor) -> Iterator[Finding]:
    if m.u_inj >= m.u_dc / math.sqrt(3.0):
        text = f"u_inj = {m.u_inj:g} V is beyond {m.u_dc / math.sqrt(3.0):.4g} V, the most that a "
        text += f"DC link of {m.u_dc:g} V gives; give at most a fifth of it"
        yield Finding(NO, "u_inj", text)
    elif m.u_inj > 1.01 * LINK_SHARE * m.u_dc:
        text = f"u_inj = {m.u_inj:g} V is above a fifth of the DC link, {LINK_SHARE * m.u_dc:g} V"
        yield Finding(LIMIT, "u_inj", text)
    elif m.u_inj < (least := MOST_DEAD_TIME * m.dead_time_voltage + threshold_voltage(m)):
        text = f"u_inj = {m.u_inj:g} V is below {least:.3g} V, which "
        text += f"dead_time, {MOST_DEAD_TIME:g} times the file's, and the switches may take"
        yield Finding(LIMIT, "u_inj", text)


def _losses(m: Motor) -> Iterator[Finding]:
    friction = m.B * m.omega_m_rated
    if friction > MUCH_FRICTION * m.tau_rated:
        text = f"B = {m.B:g} N m s/rad: friction takes {friction:.3g} N m at rated speed, "
        text += f"{friction / m.tau_rated:.0%} of rated torque: wrong unit, or a load? A load is "
        yield Finding(LIMIT, "B", text + "no part of B; rated current has to drive both")
    power = m.tau_rated * m.omega_m_rated
    if m.p_iron > MUCH_IRON[0] * power:
        weight = NO if m.p_iron > MUCH_IRON[1] * power else LIMIT
        text = f"p_iron = {m.p_iron:g} W is {m.p_iron / power:.0%} of rated power, {power:.4g} W"
        yield Finding(weight, "p_iron", text + (": wrong unit?" if weight == NO else ""))

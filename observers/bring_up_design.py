"""Check of a drive's installation: from the machine to ``bring_up_params_t``."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sensorless.machine.magnetics import currents, flux
from sensorless.machine.motor import Motor
from sensorless.observers.injection_signal import NOISE_AT, SENSOR_NOISE, sample_noise
from sensorless.observers.tracking import MOST_DEAD_TIME

VOLTAGE = 0.4
"""Of a pulse over the link's, within the circle and with room for a sagging link."""
CURRENT, MOST_CURRENT = 0.35, (0.6, 0.8, 0.95)
"""Current that a pulse gives along d over rated: least, and most for each ``HOLD``, long to
short."""
KNEE = 0.05
"""Current of a leg over rated below which dead time takes less than its full voltage."""
HOLD = (9, 3, 2)
"""Periods without voltage at a level, of which the first does not count: enough, for a current that
falls fast, and least."""
CYCLES = (16, 64)
"""Pulses along d: least and most."""
LARGEST_NOISE = SENSOR_NOISE[1] / NOISE_AT
"""Of a current sensor over rated current, RMS."""
SHARE_NOISE, MOST_NOISE = 0.03, 0.1
"""Noise of the share of lost voltage that is aimed at, and above which it is not judged."""
LEAST_LOST = 0.15
"""Share of the dead time's voltage that has to be lost: a driver that compensates leaves less."""
THRESHOLD = 0.9
"""Middle of a transistor's and its diode's threshold voltage [V]: lost also if dead time is not."""
SURELY_MOSFETS, LEAST_VOLTAGE = 60.0, 2.5
"""Link below which an inverter surely has MOSFETs, without thresholds: the check allows for them at
all others, also where ``stress`` draws none; least dead-time voltage to tell from a threshold
[V]."""
LEGS = 4.0 / 3.0
"""Voltage along phase a that all three legs lose, over that of one."""
SCALE, SENSORS = 0.16, 0.1
"""Most difference of the scale from 1, as L_d is not known much better; and what sensors and an
L_d near the motor file's take of it."""
MOST_THRESHOLD = 1.1
"""Middle of the largest thresholds of the switches [V]."""
LOPSIDED, SENSED, BY_LOST = 0.06, 0.02, 0.45
"""Most share of the probe's steps that turns them, which one channel's gain, some 20 % off, makes;
what sensors make of it, and lost voltage over the lost share of a pulse: a leg that carries little
current loses its voltage in the one or the other direction as the rotor lies."""


@dataclass(frozen=True)
class Push:
    """Pulses along d."""

    reach: float
    """current [A]"""
    rise: int
    """periods"""
    hold: int
    """periods without voltage at a level"""
    cycles: int
    short: bool
    """the current is gone before ``hold``: the falls show no lost voltage"""
    clear: bool
    """lost voltage stands out from noise"""


@dataclass(frozen=True)
class Plan:
    """Pulses, and what they cannot judge."""

    push: Push
    u_lost: float
    """voltage of a leg to judge; 0: none [V]"""
    scale_band: float
    """most difference of the scale from 1"""
    limits: tuple[str, ...]
    """what is not judged, or less sharply, and why"""


def inductance(motor: Motor, low: float, high: float) -> float:
    """d inductance while the flux goes from ``low`` to ``high`` beyond that of the magnets [H].

    Of the mean of the current's steps there and on the other side of the magnets' flux [Vs].
    """
    psi_0 = float(flux(motor.saturation, np.zeros((1, 2)))[0, 0])
    ends = psi_0 + np.array([high, low, -low, -high])
    i = currents(motor.saturation, np.stack([ends, np.zeros(4)], axis=-1))[:, 0]
    return 2.0 * (high - low) / float(i[0] - i[1] + i[2] - i[3])


def inductances(motor: Motor, push: Push) -> dict[str, float]:
    """What the current meets in the periods that the check counts [H]: rise and both levels.

    Every period of a rise adds the same flux, and the check leaves the first one out. Meanwhile and
    at the levels lost voltage and resistance take flux away, at most all of it.
    """
    step = push.reach * motor.L_d / push.rise
    lost = motor.T_s * LEGS * motor.dead_time_voltage
    falls = [lost + share * motor.T_s * motor.R_s * push.reach for share in (0.5, 1.0, 0.5)]
    top = push.rise * (step - falls[0])
    high = top - push.hold * falls[1]
    middle = high - 0.5 * push.rise * (step + falls[1])
    low = middle - push.hold * falls[2]
    least = 0.1 * step  # less would be the rounding of two currents
    ends = ((max(x, 0.0), max(y, x + least, least)) for x, y in ((high, top), (low, middle)))
    L_high, L_low = (inductance(motor, x, y) for x, y in ends)
    return {
        "L_d": inductance(motor, step, push.rise * step),
        "L_high": L_high,
        "L_low": L_low,
    }


def _rise(motor: Motor, reach: float) -> int:
    u = reach * motor.L_d / motor.T_s
    return 2 * max(1, math.ceil(u / (VOLTAGE * motor.u_dc) / 2.0 - 1e-9))


def _push(motor: Motor, u_lost: float, enough: tuple[int, int, int]) -> Push:
    """Pulses that hold as long as is enough up to each of ``MOST_CURRENT``, if any do."""
    gain = motor.T_s / motor.L_d
    reach = CURRENT * motor.i_rated
    long, medium, most = (share * motor.i_rated for share in MOST_CURRENT)
    while True:
        rise = _rise(motor, reach)
        fall = gain * (LEGS * u_lost + 0.5 * motor.R_s * reach)
        # from the top: hold, fall by half, hold; all above the knee of the legs with half of it
        room = 0.5 * reach - 2.4 * KNEE * motor.i_rated
        hold = math.floor((room / fall - 0.5 * rise) / 2.0) if fall > 0.0 else HOLD[0]
        least = enough[0 if reach <= long else 1 if reach < medium else 2]
        if hold >= least or reach >= max(medium, min(most, motor.i_max)):
            break
        reach *= 1.05
    short = hold < HOLD[2]
    hold = min(max(hold, HOLD[2]), enough[0])
    noise = sample_noise(motor, LARGEST_NOISE)
    # a fall is a difference of two samples; the level without current follows from two falls
    spread = noise * math.sqrt(10.0) / ((hold - 1) * gain * LEGS * max(u_lost, 1e-9))
    cycles = 4 * math.ceil((spread / SHARE_NOISE) ** 2 / 4.0)
    cycles = min(max(cycles, CYCLES[0]), CYCLES[1])
    return Push(reach, rise, hold, cycles, short, spread <= MOST_NOISE * math.sqrt(cycles))


def plan_bring_up(motor: Motor) -> Plan:
    """Choose the pulses for a machine; what they do not show of it is not judged."""
    u_lost = motor.dead_time_voltage
    bipolar = motor.u_dc >= SURELY_MOSFETS
    push = _push(motor, u_lost, HOLD)
    if not push.short and push.clear and (u_lost >= LEAST_VOLTAGE or not bipolar):
        return Plan(push, u_lost, SCALE, ())
    if push.short:
        why = (
            f"pulses are short: the {LEGS * u_lost:.3g} V that it takes along d, and resistance, "
            f"end a current of {push.reach:.3g} A too soon"
        )
    elif not push.clear:
        why = f"its {u_lost:.2g} V a leg are hidden in the noise of the current sensors"
    else:
        why = (
            f"its {u_lost:.2g} V a leg are less than {LEAST_VOLTAGE:g} V, which the thresholds of "
            f"bipolar transistors and diodes would hide (only below {SURELY_MOSFETS:g} V of link "
            "does the check count on MOSFETs, which have none)"
        )
    limits = [f"dead time is not judged, because {why}"]
    push = _push(motor, u_lost, (HOLD[2],) * 3)  # the scale alone
    band = SCALE
    if push.short:  # the voltage lost, unknown, is missing in the scale
        lost = LEGS * (MOST_DEAD_TIME * u_lost + (MOST_THRESHOLD if bipolar else 0.0))
        band = max(SCALE, SENSORS + lost * motor.T_s * push.rise / (push.reach * motor.L_d))
    if band > SCALE:
        limits.append(
            f"the voltage's scale may be wrong by {100.0 * band:.0f} % unseen, instead of "
            f"{100.0 * SCALE:.0f} %: up to {lost:.3g} V lost are in it"
        )
    return Plan(replace(push, cycles=CYCLES[0]), 0.0, band, tuple(limits))


def lopsided(motor: Motor, u_probe: float) -> float:
    """Most share of the steps by pulses of ``u_probe`` [V] that turns them in a drive built right.

    Inductances turn nothing: with the steps a of pulses along alpha and b along beta, it is
    |a_beta - b_alpha| over |a_alpha + b_beta|. A gain of one channel makes a sqrt(12)th of itself.
    """
    lost = LEGS * MOST_DEAD_TIME * motor.dead_time_voltage / u_probe
    return max(LOPSIDED, SENSED + BY_LOST * lost)


def design_bring_up(motor: Motor) -> dict[str, Any]:
    """Fields of ``bring_up_params_t``.

    ``u_lost`` is 0, so that nothing is judged, where short pulses, noise or thresholds hide the
    dead time.
    """
    gain = motor.T_s / motor.L_d
    u_max = VOLTAGE * motor.u_dc
    plan = plan_bring_up(motor)
    push, u_lost = plan.push, plan.u_lost
    threshold = THRESHOLD / u_lost if u_lost > 0.0 and motor.u_dc >= SURELY_MOSFETS else 0.0
    u_probe = min(CURRENT * motor.i_rated / gain, u_max)
    return {
        "T_s": motor.T_s,
        "u_probe": u_probe,
        "u_push": push.reach / (gain * push.rise),
        **inductances(motor, push),
        "R_s": motor.R_s,
        "anisotropy": (motor.L_q - motor.L_d) / (motor.L_q + motor.L_d),
        "u_lost": u_lost,
        "i_rest": 0.05 * motor.i_rated,
        "i_least": 0.1 * gain * u_probe,
        "i_stop": 0.95 * min(motor.i_trip, motor.adc_range),
        "delay_band": 0.1,
        "scale_band": plan.scale_band,
        "lopsided": lopsided(motor, u_probe),
        "lost_least": LEAST_LOST + threshold,
        "n_rest": 8,
        "n_probe": 16,
        "n_gap": 8,
        "n_push": push.rise,
        "n_hold": push.hold,
        "n_cycles": push.cycles,
    }

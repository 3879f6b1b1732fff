"""Crossings of the hand-over band in every way that a drive can cross it."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

Indices = NDArray[np.int64]


def handoff_scenarios(motor: Motor, seeds: Seeds, indices: Indices, _: int) -> Scenarios:
    """Crossings of the hand-over band, one kind after the other; the seed draws the noise.

    The hand-over band is the range of speeds where the lead passes from one estimator to the other.
    The drive crosses it upwards, dwells at its centre with a load step, and returns, at three ramps
    and 0 to 100 % of rated torque, motoring and regenerating. Then come reversals through zero,
    load steps at standstill and fast decelerations.
    """
    s = Scenarios.nominal(motor, seeds, 3.0)
    base = motor.n_rated_rpm * RPM_TO_RAD_S
    crossings = list(product((200.0, 600.0, 1200.0), (-1.0, -0.5, 0.0, 0.5, 1.0), (1.0, -1.0)))
    reversals = list(product((300.0, 900.0), (-0.5, 0.0, 0.5), (1.0, -1.0)))
    holds = list(product((0.5, 1.0), (1.0, -1.0)))
    stops = list(product((-0.5, 0.0, 0.5), (1.0, -1.0)))
    n_kinds = len(crossings) + len(reversals) + len(holds) + len(stops)
    for i, index in enumerate(indices.tolist()):
        j = index % n_kinds
        if j < len(crossings):
            ramp, load, way = crossings[j]
            _cross(
                s,
                i,
                ramp * RPM_TO_RAD_S * motor.n_rated_rpm / 1500.0,
                load * motor.tau_rated,
                way * base,
            )
            continue
        j -= len(crossings)
        if j < len(reversals):
            ramp, load, way = reversals[j]
            _segments(
                s,
                i,
                [(0.0, 0.4 * way, 0.0), (0.6, 0.4 * way, load), (1.0, -0.4 * way, load)],
                base,
                motor.tau_rated,
                ramp * RPM_TO_RAD_S * motor.n_rated_rpm / 1500.0,
            )
            s.omega_0[i] = 0.4 * way * base
            continue
        j -= len(reversals)
        if j < len(holds):
            load, way = holds[j]
            _segments(
                s,
                i,
                [(0.0, 0.0, 0.0), (0.3, 0.0, way * load), (1.5, 0.0, -way * load)],
                base,
                motor.tau_rated,
                base,
            )
            continue
        load, way = stops[j - len(holds)]
        _segments(
            s,
            i,
            [(0.0, 0.5 * way, 0.0), (0.3, 0.5 * way, load), (1.0, 0.0, load)],
            base,
            motor.tau_rated,
            2.0 * base,
        )
        s.omega_0[i] = 0.5 * way * base
    s.tau_rate[:] = motor.tau_rated / 0.05
    return s


def _segments(
    s: Scenarios,
    i: int,
    plan: list[tuple[float, float, float]],
    base: float,
    tau: float,
    rate: float,
) -> None:
    """Segments (start [s], speed / base, load / tau) for row i."""
    for j, (start, speed, load) in enumerate(plan):
        s.t[i, j] = start
        s.omega[i, j:] = speed * base
        s.tau[i, j:] = load * tau
    s.omega_rate[i] = rate


def _cross(s: Scenarios, i: int, ramp: float, load: float, base: float) -> None:
    """From 10 % of rated speed to the band's centre, a dwell and a load step, 40 %, and back."""
    low, centre, high = 0.1 * base, 7.0 / 30.0 * base, 0.4 * base
    signed = load * np.sign(base)
    up, down = abs(centre - low) / ramp, abs(high - low) / ramp
    plan = [
        (0.0, low, 0.0),
        (0.2, low, signed),
        (0.4, centre, signed),
        (0.4 + up + 0.15, centre, 0.5 * signed),
        (0.4 + up + 0.30, high, signed),
        (0.4 + 2.0 * up + 0.6, low, signed),
    ]
    _segments(s, i, plan, 1.0, 1.0, ramp)
    s.omega_0[i] = low
    s.duration[i] = 0.4 + 2.0 * up + 0.6 + down + 0.3

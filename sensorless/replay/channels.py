"""Which columns of a log are dead, or have another sign or unit, by what they hold."""

from collections.abc import Iterator, Mapping

import numpy as np

from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.replay.signature import CLEAR, PAST, apart, voltage_steps

UNLIKE = 10.0
"""How many times larger or smaller an answer of the current is that has another unit."""
LITTLE = 0.01
"""Largest current over the rated one that is worth a word."""
REST = 0.2
"""Sum of three currents over that with one of them turned, from which its sign was wrong."""


def of_sum(currents: Mapping[str, Floats]) -> Iterator[str]:
    """Which of three currents (n,) [A] has the wrong sign: the sum is twice it, and should be 0."""
    if len(currents) < 3:
        return
    total = np.sum(list(currents.values()), axis=0)
    for name, values in currents.items():
        if np.linalg.norm(total - 2.0 * values) < REST * np.linalg.norm(total):
            yield (
                f"{name} has the wrong sign, as the three currents do not add up to 0: turn it "
                f"with --map {name}=-{name}"
            )


def of_dead(currents: Mapping[str, Floats]) -> Iterator[str]:
    """Which currents (n,) [A] stay at one value."""
    for name in (dead := _still(currents)):
        if len(dead) < len(currents):
            yield (
                f"{name} is {currents[name][0]:g} A in every row: its channel is dead, or it is "
                "another column: name it with --map"
            )
    if len(dead) == len(currents):
        at = ", ".join(f"{currents[name][0]:g}" for name in dead)
        yield (
            f"{', '.join(dead)} stay at {at} A in every row: all channels are dead or frozen, or "
            "they are other columns: name them with --map"
        )


def of_still(voltages: Mapping[str, Floats]) -> Iterator[str]:
    """Whether all voltages [V] or duty cycles (n,) stay at one value."""
    if len(_still(voltages)) == len(voltages):
        at = ", ".join(f"{values[0]:g}" for values in voltages.values())
        yield (
            f"{', '.join(voltages)} stay at {at} in every row, as of no drive that runs: they were "
            "not recorded, or are other columns: name them with --map"
        )


def _still(columns: Mapping[str, Floats]) -> list[str]:
    return [name for name, values in columns.items() if not np.ptp(values) > 0.0]


def of_size(u: Floats, i: Floats, motor: Motor) -> Iterator[str]:
    """Whether the current's answer to steps of the voltage has the size that inductances let it.

    Parameters
    ----------
    u, i : as in ``of_voltage``
    """
    du, bend, _ = voltage_steps(u, i)
    if len(bend) < 4 * PAST:
        return
    pairs = [apart(du, bend, lag) for lag in (0, -1, 1, 2)]
    x, y = max(pairs, key=lambda pair: abs(complex(np.vdot(*pair))))
    both, sent = abs(complex(np.vdot(x, y))), float(np.linalg.norm(x))
    if both < CLEAR * max(sent * float(np.linalg.norm(y)), 1e-30):
        return
    over = both / sent**2 / motor.T_s
    slow, fast = sorted(1.0 / L for L in (motor.L_d, motor.L_q))
    if not slow / UNLIKE <= over <= fast * UNLIKE:
        times, word = (slow / over, "smaller") if over < slow else (over / fast, "larger")
        yield (
            f"the current's answer to the voltage is {times:.3g} times {word} than L_d and L_q of "
            f"motor {motor.name!r} let it be, and the largest current is {np.abs(i).max():.3g} A, "
            f"rated {motor.i_rated:.3g} A: check the units of currents and voltages"
        )


def of_little(i: Floats, motor: Motor) -> Iterator[str]:
    """Whether currents (n, 2) [A] are so small that they may have another unit."""
    most = float(np.abs(i).max(initial=0.0))
    if 0.0 < most < LITTLE * motor.i_rated:
        yield (
            f"no current is above {most:.3g} A, {100.0 * most / motor.i_rated:.2g} % of the rated "
            f"one of motor {motor.name!r}: check the unit, unless the motor ran without load"
        )

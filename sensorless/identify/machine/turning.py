"""Commands of a spin: a current that turns, and yields to the torque so that the rotor is damped.

A rotor on a current of fixed size and speed swings without damping. So the speed is lowered by what
the voltage along the current, u = R_s i + omega tau / (3/2 n_p i), has beside its slow part.
"""

from dataclasses import dataclass

import numpy as np

from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Command, amps

RAMP_CURRENT = 0.5
"""While the speed changes, over rated, up to the current that aligns.

Beyond that the rotor has two places beside the current, and falls out of step between them."""
CURRENTS = (0.8, 0.6)
"""While the magnet is measured, over the current that aligns: more turns the rotor off it."""
SLOW, FAST = 0.2, 0.45
"""Speeds over rated."""
START = 0.2
"""Speed of the first, careful spin over rated."""
SHARE = 0.12
"""Torque of the second ramps over rated."""
GUESS = 0.2
"""Time in which rated torque brings the rotor to rated speed, before it is known [s]."""
STIFF = 0.4
"""Torque a radian between rotor and ``RAMP_CURRENT`` over rated, for the time of a swing."""
HOLD = 0.4
"""Least time at a speed [s]."""
TURNS = 3.2
"""Least electrical turns at a speed."""


def _begin(i: float) -> list[Command]:
    return [amps(0.1, 0.0, 0.0, end=i), amps(0.3, i)]


@dataclass(frozen=True)
class _Turning:
    """Makes commands at the ramps' current for a rotor of a certain inertia."""

    plate: Nameplate
    J: float
    aligns: float

    @property
    def i(self) -> float:
        return min(RAMP_CURRENT * self.plate.i_rated, self.aligns)

    @property
    def stiff(self) -> float:
        """Torque a radian between rotor and current [N m]."""
        p = self.plate
        return STIFF * p.tau_rated * self.i / (RAMP_CURRENT * p.i_rated)

    @property
    def swing(self) -> float:
        """Frequency at which the rotor swings about the current [rad/s]."""
        return float(np.sqrt(self.plate.n_p * self.stiff / self.J))

    def amps(
        self, time: float, omega: tuple[float, float], start: float, end: float | None = None
    ) -> Command:
        """Damped by half: d u / d delta = omega d tau / d delta / (3/2 n_p i)."""
        p = self.plate
        slope = max(omega) * self.stiff / (1.5 * p.n_p * self.i)
        follow = 0.2 * self.swing * p.T_s
        return amps(time, start, end=end, omega=omega, damp=self.swing / slope, follow=follow)

    def ramp(self, time: float, a: float, b: float) -> Command:
        return self.amps(time, (a, b), self.i)

    def hold(self, omega: float, periods: float = 3.0) -> Command:
        time = max(HOLD, periods * 2.0 * np.pi / self.swing, TURNS * 2.0 * np.pi / omega)
        return self.amps(time, (omega, omega), self.i)


def first_spin(plate: Nameplate, aligns: float, ramp: float) -> list[Command]:
    """Commands of a slow spin, its ramps ``ramp`` seconds long; ``aligns``: as in the second."""
    t = _Turning(plate, GUESS * plate.tau_rated * plate.n_p / plate.omega, aligns)
    top = START * plate.omega
    return [*_begin(t.i), t.ramp(ramp, 0.0, top), t.hold(top, 0.0), t.ramp(ramp, top, 0.0)]


def second_spin(plate: Nameplate, J: float, aligns: float, careful: float) -> list[Command]:
    """Commands of ramps up and down, and of currents at two speeds that tell the magnet.

    ``aligns``: current that aligns [A]; ``careful``: factor on the times of the ramps.
    """
    t = _Turning(plate, J, aligns)
    period = 2.0 * np.pi / t.swing
    slope = SHARE / STIFF * t.stiff * plate.n_p / J / careful
    low, high = SLOW * plate.omega, FAST * plate.omega

    def ramp(a: float, b: float) -> Command:
        return t.ramp(max(0.5 * np.pi * abs(b - a) / slope, 4.0 * careful * period), a, b)

    def magnet(omega: float) -> list[Command]:
        out, last, even = [], t.i, (omega, omega)
        for share in CURRENTS:
            out += [t.amps(period, even, last, share * aligns)]
            out += [t.amps(max(HOLD, TURNS * 2.0 * np.pi / omega), even, share * aligns)]
            last = share * aligns
        return [*out, t.amps(period, even, last, t.i), t.hold(omega, 1.0)]

    return [
        *_begin(t.i),
        ramp(0.0, high), t.hold(high), ramp(high, low), t.hold(low), ramp(low, high),
        t.hold(high), ramp(high, low), t.hold(low), *magnet(low),
        ramp(low, high), t.hold(high), *magnet(high), ramp(high, 0.0),
    ]  # fmt: skip

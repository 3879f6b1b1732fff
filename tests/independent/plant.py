"""A machine on a switching inverter that shares no code with ``core/sim``: many at once, in NumPy.

Stator frame, complex space vectors; d psi/dt = u - R_s i, currents from the machine file's
saturation. A triangular carrier with one command a period; each edge that the current works
against comes later by the dead time, or by what stops a small current, if that is sooner.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

Vectors = NDArray[np.complex128]
PHASES: Vectors = np.exp(2j * np.pi / 3.0 * np.arange(3))[:, None]


@dataclass
class Plant:
    """n machines; arrays are (n,)."""

    motor: Motor
    scenarios: Scenarios
    map: Array
    """saturation of each, ``flux_map_t``: numbers alone"""
    psi: Vectors
    """stator flux [Vs], stator frame"""
    theta: Floats
    """electrical angle [rad]"""
    omega: Floats
    """shaft [rad/s]"""

    def current(self, psi: Vectors, theta: Floats) -> Vectors:
        """Stator currents [A] of fluxes [Vs]: a machine without bridge term and correction."""
        m, turn = self.map, np.exp(1j * theta)
        turned = psi * turn.conj()
        d, q = turned.real, turned.imag
        abs_d, abs_q = np.abs(d), np.abs(q)
        cross = abs_d ** m["U"] * abs_q ** m["V"]
        i_d = (m["a_d0"] + m["a_dd"] * abs_d ** m["S"] + m["c_d"] * cross * q * q) * d - m["i_f"]
        i_q = (m["a_q0"] + m["a_qq"] * abs_q ** m["T"] + m["c_q"] * cross * d * d) * q
        return np.asarray((i_d + 1j * i_q) * turn)

    def torque(self) -> Floats:
        """Torque [N m]."""
        i = self.current(self.psi, self.theta)
        return np.asarray(1.5 * self.motor.n_p * (self.psi.conj() * i).imag)

    def advance(self, command: Vectors, u_dc: Floats, load: Floats, steps: int) -> None:
        """One period under a voltage command [V], in midpoint steps."""
        T_s = self.motor.T_s
        h = T_s / steps
        leg = (command * PHASES.conj()).real
        leg = leg - 0.5 * (leg.max(axis=0) + leg.min(axis=0))
        duty = np.clip(0.5 + leg / u_dc, 0.0, 1.0)
        commanded = 0.5 * T_s * (1.0 - duty), 0.5 * T_s * (1.0 + duty)
        rise, fall = (x.copy() for x in commanded)
        stops = self.motor.L_d / (2.0 / 3.0 * u_dc)
        for step in range(steps):
            begin, end = step * h, (step + 1) * h
            i_s = self.current(self.psi, self.theta)
            i = (i_s * PHASES.conj()).real
            late = np.minimum(self.scenarios.dead_time, np.abs(i) * stops)
            for edge, at, against in ((rise, commanded[0], i > 0.0), (fall, commanded[1], i < 0.0)):
                now = (at >= begin) & (at < end) & against
                edge[now] += late[now]
            on = np.clip(np.minimum(fall, end) - np.maximum(rise, begin), 0.0, h) / h
            self._midpoint(2.0 / 3.0 * ((on - 0.5) * u_dc * PHASES).sum(axis=0), i_s, load, h)

    def _midpoint(self, u: Vectors, i: Vectors, load: Floats, h: float) -> None:
        half = self._slopes(self.psi, i, self.omega, u, load)
        x = (self.psi, self.theta, self.omega)
        middle = [a + 0.5 * h * b for a, b in zip(x, half, strict=True)]
        i = self.current(middle[0], middle[1].real)
        slopes = self._slopes(middle[0], i, middle[2].real, u, load)
        self.psi = self.psi + h * slopes[0]
        self.theta = self.theta + h * slopes[1].real
        self.omega = self.omega + h * slopes[2].real

    def _slopes(
        self, psi: Vectors, i: Vectors, omega: Floats, u: Vectors, load: Floats
    ) -> tuple[Vectors, Floats, Floats]:
        m, s = self.motor, self.scenarios
        torque = 1.5 * m.n_p * (psi.conj() * i).imag
        J = s.J * m.J
        return u - s.R_s * m.R_s * i, m.n_p * omega, (torque - load - m.B * omega) / J

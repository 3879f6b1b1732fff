"""The injection estimator with an ideal machine at a held speed."""

import cmath
import math
from collections.abc import Callable

import numpy as np

from sensorless.core.api import struct_dtype
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor, Saturation
from sensorless.plant.case import PlantCase
from sensorless.plant.run import plant_arrays

Call = Callable[..., None]

STATE = struct_dtype("hfi_state_t")
DESIGN = DriveDesign(
    estimator="smo", hfi_pll_hz=20.0, speed_hz=2.0, speed_weight=0.0, i_q_slew=150.0
)


class Bench:
    """Estimator and ideal machine at a held speed, fed with the EMF and the injection.

    Timing of the drive: the voltage computed at k acts over [k+1, k+2].
    """

    def __init__(
        self,
        c: Call,
        motor: Motor,
        rpm: float,
        theta_err: float,
        *,
        closed: bool,
        design: DriveDesign = DESIGN,
        sign: float = 1.0,
        current: complex | None = None,
    ) -> None:
        """current: [A] held on the saturated machine at standstill; none: a linear machine at 0."""
        self.c, self.T_s, self.sign, self.motor = c, motor.T_s, sign, motor
        assert current is None or rpm == 0.0
        self.omega = motor.rpm_to_electrical(rpm)
        saturation = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
        saturation = saturation if current is None else motor.saturation
        self.hold = 0.0 if current is None else motor.R_s * current * cmath.exp(0.5j)
        case = PlantCase(
            T_s=motor.T_s,
            n_p=motor.n_p,
            R_s=motor.R_s,
            saturation=saturation,
            J=math.inf,
            B=0.0,
            i_d=0.0 if current is None else current.real,
            i_q=0.0 if current is None else current.imag,
            theta_e=0.5,
            omega_m=self.omega / motor.n_p,
        )
        self.plant, self.state = plant_arrays(case)
        self.emf = self.omega * motor.psi_f
        self.p = np.array(control_record(motor, design)["hfi"]).reshape(1)
        if not closed:
            self.p["pll"]["k_p"] = self.p["pll"]["k_i"] = 0.0
        self.x = np.zeros(1, dtype=STATE)
        self.x["pll"]["theta"] = 0.5 - theta_err
        self.x["pll"]["omega"] = self.omega
        self.wait = 0.0j
        self.theta = 0.5
        self.acceleration = 0.0  # of the held speed, electrical [rad/s^2]

    def _injection(self) -> complex:
        """Sign times direction for the period after next."""
        at, sign = np.empty(2, dtype=np.float32), np.empty(1, dtype=np.float32)
        self.c("hfi_direction", self.p, self.x, self.T_s, at)
        self.c("hfi_inject", self.p, self.x, 1, sign)
        return float(sign[0]) * complex(at[0], at[1])

    def step(self) -> None:
        """One period; ``x`` then holds what was demodulated at its start."""
        i = complex(self.state["i_d"][0], self.state["i_q"][0]) * cmath.exp(1j * self.theta)
        own = float(self.x["pll"]["theta"][0])
        self.c("hfi_observe", self.p, self.x, i.real, i.imag, own, self.omega, self.T_s)
        u_inj = float(self.p["u_inj"][0]) * self.sign
        mid = self.theta + 0.5 * self.omega * self.T_s
        u = 1j * self.emf * cmath.exp(1j * mid) + u_inj * self.wait + self.hold
        self.wait = self._injection()
        plant_run(self.plant, self.state, np.array([[u.real, u.imag, 0.0]]))
        self.theta += self.omega * self.T_s
        self.omega += self.acceleration * self.T_s
        self.emf = self.omega * self.motor.psi_f
        self.state["omega_m"] = self.omega / self.motor.n_p

    def run(self, periods: int, average: int) -> tuple[float, float, float]:
        """Mean error signal, amplitude [A] and angle error [deg] over the last periods."""
        rows = np.empty((periods, 3))
        for k in range(periods):
            err = math.remainder(self.theta - float(self.x["pll"]["theta"][0]), 2.0 * math.pi)
            self.step()
            rows[k] = self.x["err"][0], self.x["amplitude"][0], math.degrees(err)
        err, amplitude, angle = np.mean(rows[-average:], axis=0)
        return float(err), float(amplitude), float(angle)


def error_signal(motor: Motor, e: float) -> float:
    """Exact normalised error: (L_q - L_d) sin e cos e / sqrt(L_q^2 cos^2 e + L_d^2 sin^2 e)."""
    c, s = math.cos(e), math.sin(e)
    return (motor.L_q - motor.L_d) * s * c / math.hypot(motor.L_q * c, motor.L_d * s)

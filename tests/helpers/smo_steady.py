"""A sliding-mode observer in an exact steady state, one period after the other."""

import cmath
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sensorless.core.api import Array, struct_dtype
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.smo_design import super_twisting
from sensorless.plant.case import PlantCase
from sensorless.plant.run import plant_arrays

Call = Callable[..., None]

STATE = struct_dtype("smo_state_t")
ESTIMATE = struct_dtype("emf_estimate_t")

EXACT = DriveDesign(
    estimator="smo",
    smo_pll_hz=20.0,
    smo_cross_hz=math.inf,
    smo_emf_hz=math.inf,
    smo_gain=1.0,
    L_q_bias=1.0,
    speed_hz=1.0,
)
"""No filters, the exact L_q, a slow speed loop."""


def linear(motor: Motor) -> Motor:
    """Return the machine without saturation."""
    return replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))


def holding_voltage(motor: Motor, rpm: float, i: complex) -> complex:
    """Voltage, held in the stator frame from angle 0 on, that brings the flux of ``i`` back [V]."""
    omega = motor.rpm_to_electrical(rpm)
    case = PlantCase(
        T_s=motor.T_s,
        n_p=motor.n_p,
        R_s=motor.R_s,
        saturation=motor.saturation,
        J=math.inf,
        B=0.0,
        i_d=i.real,
        i_q=i.imag,
        theta_e=0.0,
        omega_m=omega / motor.n_p,
    )

    def moved(u: Floats) -> Floats:
        plant, state = plant_arrays(case, 16)
        rows = plant_run(plant, state, np.array([[u[0], u[1], 0.0]]))
        return np.asarray(rows[1, 2:4] - rows[0, 2:4])

    u = np.zeros(2)
    for _ in range(6):
        here = moved(u)
        slope = np.stack([moved(u + step) - here for step in np.eye(2)], axis=-1)
        u = u - np.linalg.solve(slope, here)
    assert np.max(np.abs(moved(u))) < 1e-12
    return complex(u[0], u[1])


def params(
    motor: Motor,
    gain: float = 315.0,
    *,
    cure: bool = True,
    k: float = 1e4,
    R_s: float | None = None,
) -> Array:
    """A record of ``smo_params_t`` with gain ``gain`` [V/A] at the origin."""
    p = np.array(control_record(motor, EXACT)["smo"]).reshape(1)
    p["k"], p["half_a"], p["lag_cure"] = k, gain / k, float(cure)
    root, climb = super_twisting(motor, k)
    p["root"], p["climb"] = root, climb * motor.T_s
    p["R_s"] = motor.R_s if R_s is None else R_s
    return p


def angles(
    c: Call,
    motor: Motor,
    p: Array,
    rpm: float,
    i: complex,
    L_q: float | None = None,
    u_lost: float = 0.0,
    periods: int = 2500,
) -> tuple[Floats, Floats]:
    """Truth minus estimate [deg] and model-current error [A] in a steady state of ``i`` [A].

    u_lost: voltage that the drive commands along the current and the inverter loses [V].
    """
    omega = motor.rpm_to_electrical(rpm)
    u = holding_voltage(motor, rpm, i)
    u += u_lost * i / abs(i) * cmath.exp(0.5j * omega * motor.T_s) if u_lost else 0.0
    x, y = np.zeros(1, dtype=STATE), np.zeros(1, dtype=ESTIMATE)
    y["pll"]["omega"], x["omega_f"], y["pll"]["theta"] = omega, omega, 0.1
    theta = np.remainder(omega * motor.T_s * np.arange(periods), 2.0 * np.pi)
    now = i * np.exp(1j * theta)
    was = u * np.exp(1j * (theta - omega * motor.T_s))
    none = np.zeros(periods)
    rows = np.stack([now.real, now.imag, was.real, was.imag, none, none], axis=-1)
    rows = np.ascontiguousarray(rows, dtype=np.float32)
    c("smo_periods", p, x, y, rows, periods, motor.L_q if L_q is None else L_q, omega, motor.T_s)
    away = theta - rows[:, 4] + np.pi
    return np.rad2deg(np.remainder(away, 2.0 * np.pi) - np.pi)[-500:], (rows[:, 5] - now.real)[
        -500:
    ]

"""Flux maps that several tests integrate or fit."""

import dataclasses
from functools import cache
from pathlib import Path

import numpy as np

from sensorless.machine.correction_fit import corrected
from sensorless.machine.flux_correction import FluxCorrection
from sensorless.machine.magnetics import Floats
from sensorless.machine.map_file import load_map
from sensorless.machine.motor import Motor, Saturation

MEASURED_MAP = Path(__file__).parents[1] / "data" / "flux_maps" / "baldor_400rpm_map.csv"
"""Measured on the machine of ``pmsyrm_5600w``."""

BRIDGE = Saturation(
    a_d0=3.96,
    a_dd=28.5,
    S=4,
    a_q0=5.89,
    a_qq=2.67,
    T=6,
    a_dq=41.5,
    U=1,
    V=1,
    a_b=81.75,
    a_bp=1.0,
    k_q=0.1,
    psi_n=0.804,
    W=2,
)
"""A machine whose bridges saturate against the magnet."""


@cache
def measured_machine() -> Motor:
    """The shipped ``pmsyrm_5600w``, whose published model errs by 3 %, and the measured map."""
    return corrected(Motor.load("pmsyrm_5600w"), *load_map(MEASURED_MAP))


def rough_correction(motor: Motor, size: float = 0.05) -> FluxCorrection:
    """Random coefficients of about ``size`` of what the magnet's flux and rated current make."""
    c = np.random.default_rng(7).standard_normal((9, 6)) * size * motor.psi_f * motor.i_rated
    reach = motor.psi_f + motor.L_d * motor.i_max
    q = 1.2 * motor.L_q * motor.i_max
    return FluxCorrection(-0.5 * reach, 1.3 * reach, q, tuple(map(tuple, c.tolist())))


@cache
def rough_machine() -> Motor:
    """The paper's machine with a correction that is nobody's: no bridge, a smooth model."""
    motor = Motor.load("paper")
    return dataclasses.replace(motor, flux_correction=rough_correction(motor, 0.01))


def knee_currents(psi: Floats) -> Floats:
    """Currents of a machine whose q iron gives out at once and whose axes couple by a bell.

    The gradient of psi^2 / 2 L terms, of a soft step in psi_q, and of
    1.2 exp(-((psi_d - 0.3) / 0.35)^2) psi_q^2 / (0.25 + psi_q^2).
    """
    d, q = psi[..., 0], psi[..., 1]
    bell = 1.2 * np.exp(-(((d - 0.3) / 0.35) ** 2))
    share = q**2 / (0.25 + q**2)
    knee = 0.75 * np.sign(q) * np.logaddexp(0.0, (np.abs(q) - 0.7) / 0.03)
    i_d = (d - 0.47) / 0.03 - 2.0 * (d - 0.3) / 0.35**2 * bell * share
    i_q = q / 0.15 + knee + bell * 0.5 * q / (0.25 + q**2) ** 2
    return np.stack([i_d, i_q], axis=-1)


def knee_map() -> tuple[Floats, Floats]:
    """Currents and flux linkages of that machine, (441, 2) each."""
    axes = np.linspace(-0.2, 0.9, 21), np.linspace(-1.25, 1.25, 21)
    psi = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return knee_currents(psi), psi

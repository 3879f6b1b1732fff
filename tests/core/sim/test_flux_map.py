"""The flux map: equations, reciprocity, and the numbers that the saturation set was fitted to."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sensorless.machine.magnetics import (
    Floats,
    cross_angle,
    currents,
    flux,
    inverse_inductance,
    torque,
)
from sensorless.machine.motor import Motor, Saturation
from tests.helpers.machines import BRIDGE

Map = Callable[[Saturation, Floats], Floats]

STRESS = Saturation(
    a_d0=13.0, a_dd=0.59097761, S=4, a_q0=1.9612252, a_qq=1.90, T=2, a_dq=3.114, i_f=13.479581
)
ODD = Saturation(
    a_d0=5.0,
    a_dd=2.0,
    S=3,
    a_q0=4.0,
    a_qq=3.0,
    T=5,
    a_dq=2.0,
    U=5,
    V=4,
    i_f=2.0,
    a_b=3.0,
    a_bp=0.5,
    k_q=0.7,
    psi_n=0.4,
    W=7,
)

RATED = 3.98 * math.sqrt(2.0)

# i_q [A] at i_d = 0: torque, psi_d, psi_q, incremental L_d, L_q, L_dq, theta_cross [deg]
FITTED = [
    (1.0, 2.96, 0.9862, 0.2564, 0.0635, 0.2336, -0.0123, -4.13),
    (2.04, 5.93, 0.9691, 0.4833, 0.0645, 0.2053, -0.0200, -7.92),
    (4.0, 11.05, 0.9210, 0.8538, 0.0657, 0.1759, -0.0281, -13.5),
    (RATED, 14.73, 0.8724, 1.1271, 0.0655, 0.1605, -0.0312, -16.6),
    (2.0 * RATED, 23.63, 0.6996, 1.9209, 0.0567, 0.1243, -0.0280, -19.8),
]


def saturation(name: str, motor: Motor) -> Saturation:
    return {"paper": motor.saturation, "stress": STRESS, "bridge": BRIDGE, "odd": ODD}[name]


NAMES = ("paper", "stress", "bridge", "odd")


def fluxes(n: int) -> Floats:
    return np.random.default_rng(5).uniform((-1.0, -2.5), (2.2, 2.5), (n, 2))


@pytest.mark.parametrize("name", NAMES)
def test_equations(name: str, motor: Motor, map_currents: Map) -> None:
    """C and NumPy give the same currents."""
    s = saturation(name, motor)
    psi = fluxes(500)
    want = map_currents(s, psi)
    assert np.max(np.abs(currents(s, psi) - want) / (1.0 + np.abs(want))) < 1e-13


@pytest.mark.parametrize("name", NAMES)
def test_reciprocity(name: str, motor: Motor) -> None:
    """di_d/dpsi_q = di_q/dpsi_d everywhere, so the map has an energy."""
    gamma = inverse_inductance(saturation(name, motor), fluxes(500), step=1e-5)
    gap = np.abs(gamma[:, 0, 1] - gamma[:, 1, 0])
    assert np.max(np.abs(gamma[:, 0, 1])) > 1.0
    assert np.max(gap / (1.0 + np.abs(gamma).max(axis=(1, 2)))) < 1e-8


@pytest.mark.parametrize("name", ["paper", "stress"])
def test_positive_definite(name: str, motor: Motor) -> None:
    """Least eigenvalue of d i / d psi above 1.86 1/H in use: the map is one to one."""
    gamma = inverse_inductance(saturation(name, motor), fluxes(4000))
    least = float(np.linalg.eigvalsh(0.5 * (gamma + np.swapaxes(gamma, 1, 2))).min())
    assert 1.85 < least < 2.6


@pytest.mark.parametrize("name", NAMES)
def test_inverse(name: str, motor: Motor) -> None:
    """Flux of the current of a flux is that flux."""
    s = saturation(name, motor)
    psi = fluxes(200) if name in ("paper", "stress") else 0.4 * fluxes(200)
    assert np.max(np.abs(flux(s, currents(s, psi)) - psi)) < 1e-9


def test_data_sheet_at_zero_current(motor: Motor) -> None:
    """At zero current the saturated machine is the one of the datasheet."""
    psi = flux(motor.saturation, np.zeros((1, 2)))
    assert psi[0] == pytest.approx([motor.psi_f, 0.0], abs=1e-6)
    L = np.linalg.inv(inverse_inductance(motor.saturation, psi)[0])
    assert L[0, 0] == pytest.approx(motor.L_d, rel=1e-5)
    assert L[1, 1] == pytest.approx(motor.L_q, rel=1e-5)
    assert L[0, 1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("row", FITTED, ids=lambda row: f"{row[0]:.2f}A")
def test_fitted_numbers(row: tuple[float, ...], motor: Motor) -> None:
    """Torque, fluxes, incremental inductances and cross-coupling angle, each to its last digit."""
    i = np.array([[0.0, row[0]]])
    psi = flux(motor.saturation, i)
    L = np.linalg.inv(inverse_inductance(motor.saturation, psi)[0])
    assert torque(motor, i)[0] == pytest.approx(row[1], abs=0.006)
    assert psi[0] == pytest.approx(row[2:4], abs=6e-5)
    assert (L[0, 0], L[1, 1], L[0, 1]) == pytest.approx(row[4:7], abs=6e-5)
    digit = 0.06 if abs(row[7]) > 10.0 else 0.006
    assert np.rad2deg(cross_angle(motor, i)[0]) == pytest.approx(row[7], abs=digit)


@pytest.mark.parametrize(
    ("i_q", "angle"),
    [(1.0, -4.02), (2.04, -7.90), (4.0, -14.6), (RATED, -19.9), (2.0 * RATED, -39.0)],
)
def test_cross_angle_of_the_stress_set(i_q: float, angle: float, motor: Motor) -> None:
    """The harder saturation set turns its axes by up to 39 degrees."""
    hard = replace(motor, saturation=STRESS)
    got = float(np.rad2deg(cross_angle(hard, np.array([[0.0, i_q]]))[0]))
    assert got == pytest.approx(angle, abs=0.06)


def test_drop_of_inductance_at_rated_current(motor: Motor) -> None:
    """30 % of the apparent and 44 % of the incremental q inductance are gone at rated current."""
    psi = flux(motor.saturation, np.array([[0.0, motor.i_rated]]))
    L = np.linalg.inv(inverse_inductance(motor.saturation, psi)[0])
    assert 1.0 - psi[0, 1] / motor.i_rated / motor.L_q == pytest.approx(0.30, abs=0.005)
    assert 1.0 - L[1, 1] / motor.L_q == pytest.approx(0.44, abs=0.005)

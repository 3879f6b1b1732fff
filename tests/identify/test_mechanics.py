"""Inertia, friction and their scatter from spins whose torque is known."""

import numpy as np
import pytest

from sensorless.identify.machine.mechanics import NO_MECHANICS, Mechanics, fit_mechanics
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

PLATE = Nameplate.of(Motor.load("paper"))
T_S = 1e-4
J, B, TAU_0 = 0.01, 0.02, 0.3
HOLD, RAMP = 12000, 6000
"""Periods at a speed, and from one to the next."""


def spin(*speeds: float) -> tuple[Floats, Floats]:
    """Electrical speed, up from standstill and held at each of ``speeds``, and the segments."""
    half = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, RAMP))
    parts, last = [], 0.0
    for speed in speeds:
        parts += [last + (speed - last) * half, np.full(HOLD, speed)]
        last = speed
    segment = np.repeat(np.arange(float(len(parts))), [len(x) for x in parts])
    return np.concatenate(parts), segment


def fitted(omega: Floats, segment: Floats, more: Floats) -> Mechanics:
    """Of the shaft's torque and ``more`` [N m]."""
    speed = omega / PLATE.n_p
    tau = J * np.gradient(speed, T_S) + B * speed + TAU_0 + more
    i = np.full(len(tau), 2.0 + 0j)
    psi = np.asarray(0.5 - 1j * tau / (3.0 * PLATE.n_p))
    return fit_mechanics(i, psi, omega, segment, PLATE, T_S)


def test_the_scatter_is_that_of_least_squares() -> None:
    """Stretches go from third to third of what is held; each has a torque too much or too little.

    Their accelerations, speeds and means by hand, the rest by the textbook.
    """
    omega, segment = spin(200.0, 80.0, 200.0, 80.0)
    wrong = np.array([0.02, -0.05, 0.03, 0.06, -0.04, 0.01, -0.03])
    thirds = [RAMP + k * (RAMP + HOLD) + HOLD * n // 3 for k in range(4) for n in (1, 2)]
    more = np.zeros(len(omega))
    for a, b, x in zip(thirds, thirds[1:], wrong, strict=False):
        more[a:b] = x
    found = fitted(omega, segment, more)
    high, low = 200.0 / PLATE.n_p, 80.0 / PLATE.n_p
    slope = (low - high) / (T_S * (2 * HOLD / 3 + RAMP))
    way = 0.5 * (high + low)
    X = np.array([(0, 1, high), (slope, 1, way), (0, 1, low), (-slope, 1, way),
                  (0, 1, high), (slope, 1, way), (0, 1, low)])  # fmt: skip
    inverse = np.linalg.inv(X.T @ X)
    x = inverse @ X.T @ wrong
    left = wrong - X @ x
    assert found.J == pytest.approx(J + x[0], rel=0.02)
    assert found.J_std == pytest.approx(np.sqrt(inverse[0, 0] * (left @ left) / 4), rel=0.05)
    assert (found.tau_0, found.B) == pytest.approx((TAU_0 + x[1], B + x[2]), rel=0.02)
    assert found.residual == pytest.approx(np.sqrt(np.mean(left**2)), rel=0.05)


def test_a_short_spin_counts_its_ramps_where_they_are_fast_and_one_friction() -> None:
    """Below a quarter of the speed the torque is not measured, and here it is wrong."""
    omega, segment = spin(200.0, 0.0)
    slow = 9.0 * (omega < 0.24 * 200.0)
    found = fitted(omega, segment, slow - B * omega / PLATE.n_p)
    assert (found.J, found.tau_0, found.B) == pytest.approx((J, TAU_0, 0.0), rel=0.02)
    assert fitted(omega[: RAMP // 4], segment[: RAMP // 4], 0.0 * omega[: RAMP // 4]) == (
        NO_MECHANICS
    )

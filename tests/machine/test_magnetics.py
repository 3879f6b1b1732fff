"""Design quantities of the machine against brute force and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from sensorless.errors import UserError
from sensorless.machine.magnetics import (
    apparent_q_inductance,
    cross_angle,
    cross_term,
    currents,
    flux,
    inverse_inductance,
    iron_conductance,
    mtpa,
    torque,
)
from sensorless.machine.motor import Motor, Saturation


@pytest.fixture(scope="module")
def linear(motor: Motor) -> Motor:
    return replace(motor, saturation=Saturation.linear(motor.L_d, motor.L_q, motor.psi_f))


def current_for(motor: Motor, tau: float) -> tuple[float, float]:
    """The point of the curve of maximum torque per ampere with torque ``tau``."""
    line = mtpa(motor, 400)
    got = torque(motor, line)
    return float(np.interp(tau, got, line[:, 0])), float(np.interp(tau, got, line[:, 1]))


@pytest.mark.parametrize(("tau", "i_d", "i_q"), [(6.0, -0.618, 1.844), (14.0, -2.16, 3.62)])
def test_mtpa_of_the_saturated_machine(motor: Motor, tau: float, i_d: float, i_q: float) -> None:
    """Numbers that were computed independently of this project."""
    assert current_for(motor, tau) == pytest.approx((i_d, i_q), abs=6e-3)


@pytest.mark.parametrize(("tau", "i_d", "i_q"), [(6.0, -0.62, 1.77), (14.0, -1.80, 3.35)])
def test_mtpa_of_the_linear_machine(linear: Motor, tau: float, i_d: float, i_q: float) -> None:
    """The same for constant inductances."""
    assert current_for(linear, tau) == pytest.approx((i_d, i_q), abs=6e-3)


@pytest.mark.parametrize("amplitude", [0.5, 2.0, 5.63, 8.4])
@pytest.mark.parametrize("kind", ["linear", "saturated"])
def test_mtpa_against_brute_force(amplitude: float, kind: str, motor: Motor, linear: Motor) -> None:
    """No other direction of the same current gives more torque."""
    machine = {"linear": linear, "saturated": motor}[kind]

    def loss(angle: float) -> float:
        i = amplitude * np.array([[-math.sin(angle), math.cos(angle)]])
        return -float(torque(machine, i)[0])

    best = minimize_scalar(loss, bounds=(0.0, 1.5), method="bounded", options={"xatol": 1e-10})
    machine = replace(machine, i_max=amplitude)
    i_d, i_q = mtpa(machine, 5)[-1]
    assert math.hypot(i_d, i_q) == pytest.approx(amplitude)
    assert math.atan2(-i_d, i_q) == pytest.approx(best.x, abs=2e-3)
    assert -loss(math.atan2(-i_d, i_q)) == pytest.approx(-best.fun, rel=1e-5)


def test_mtpa_of_a_round_machine(motor: Motor) -> None:
    """Without saliency all current is torque current."""
    round_rotor = replace(motor, saturation=Saturation.linear(0.05, 0.05, motor.psi_f))
    assert np.max(np.abs(mtpa(round_rotor)[:, 0])) < 0.01 * motor.i_max


def test_mtpa_starts_at_zero_and_grows(motor: Motor) -> None:
    """The curve begins without current; both components grow in size."""
    i_d, i_q = mtpa(motor).T
    assert (i_d[0], i_q[0]) == pytest.approx((0.0, 0.0))
    assert np.all(np.diff(i_q) > 0.0)
    assert np.all(np.diff(i_d) <= 0.0)


def test_linear_machine(linear: Motor) -> None:
    """Flux, inductance, torque and cross angle of constant inductances."""
    i = np.array([[-2.0, 3.0], [1.0, -4.0], [0.0, 0.0]])
    psi = flux(linear.saturation, i)
    assert psi[:, 0] == pytest.approx(linear.psi_f + linear.L_d * i[:, 0])
    assert psi[:, 1] == pytest.approx(linear.L_q * i[:, 1])
    tau = 1.5 * linear.n_p * (linear.psi_f + (linear.L_d - linear.L_q) * i[:, 0]) * i[:, 1]
    assert torque(linear, i) == pytest.approx(tau)
    L = np.linalg.inv(inverse_inductance(linear.saturation, psi))
    assert np.broadcast_to(np.diag([linear.L_d, linear.L_q]), (3, 2, 2)) == pytest.approx(
        L, abs=1e-8
    )
    assert cross_angle(linear, i) == pytest.approx(0.0, abs=1e-8)


def test_cross_angle_turns_the_axes_of_the_inductance(motor: Motor) -> None:
    """The axis of least incremental inductance, where injection locks, lies at -theta_cross."""
    i = np.array([[-0.6, 1.8], [0.0, 5.0], [-2.0, 3.6], [0.0, -2.0]])
    angle = cross_angle(motor, i)
    L = np.linalg.inv(inverse_inductance(motor.saturation, flux(motor.saturation, i)))
    for matrix, at in zip(L, angle, strict=True):
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        direction = vectors[:, np.argmin(values)]
        assert abs(math.sin(math.atan2(direction[1], direction[0]) + at)) < 1e-5
    assert angle[3] > 0.0 > angle[0]


def test_cross_angle_at_6_newton_metres(motor: Motor) -> None:
    """-8.00 degrees at i_d = 0, -7.32 on the curve of maximum torque per ampere."""
    i = np.array([[0.0, 2.065], [-0.618, 1.844]])
    assert np.rad2deg(cross_angle(motor, i)) == pytest.approx([-8.00, -7.32], abs=0.015)


def test_apparent_inductance(motor: Motor) -> None:
    """psi_q / i_q, falling with current."""
    i = np.array([[0.0, 0.01], [0.0, 2.0], [0.0, 5.63]])
    L = apparent_q_inductance(motor, i)
    assert L[0] == pytest.approx(motor.L_q, rel=3e-3)
    assert np.all(np.diff(L) < 0.0)
    assert pytest.approx(flux(motor.saturation, i)[:, 1]) == L * i[:, 1]


def test_flux_map_is_inverted_over_the_working_range(motor: Motor) -> None:
    """Currents up to twice rated in every direction."""
    angle = np.linspace(-np.pi, np.pi, 73)
    for amplitude in (0.1, 3.0, 11.26):
        i = amplitude * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        assert np.max(np.abs(currents(motor.saturation, flux(motor.saturation, i)) - i)) < 1e-9


def test_a_map_without_solution_is_refused() -> None:
    """A current that no flux linkage makes is a mistake in the coefficients, told in one line."""
    folded = Saturation(a_d0=1.0, a_q0=-1.0, a_qq=1.0, T=2)
    with pytest.raises(UserError, match="saturation"):
        flux(folded, np.array([[0.0, math.nan]]))


def test_the_cross_term_is_that_of_the_core(motor: Motor) -> None:
    s, psi = motor.saturation, np.array([[0.9, 0.4], [1.2, -0.7], [-0.3, 0.5]])
    both = currents(s, psi) - currents(replace(s, a_dq=0.0), psi)
    assert s.a_dq > 0.0
    assert s.a_dq * np.stack(cross_term(psi, s.U, s.V), axis=1) == pytest.approx(both, rel=1e-9)


def test_iron_loses_its_power_at_the_voltage_of_rated_speed(motor: Motor) -> None:
    """Three phases, each with the RMS value of the magnet's voltage."""
    phase = motor.omega_rated * motor.psi_f / math.sqrt(2.0)
    assert 3.0 * phase**2 * iron_conductance(motor, 100.0) == pytest.approx(100.0)

"""The joint fit on pulses computed from a known machine, and the lost voltage at edges."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sensorless.identify.machine.edges import at_edges
from sensorless.identify.machine.electric import DIRECTIONS, Complex, Inverter, Sensors, Stator
from sensorless.identify.machine.joint import fit_jointly
from sensorless.identify.machine.model import fit_model
from sensorless.identify.machine.pulses import Group
from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
T_S = 1e-4
N = 240
"""Periods of a pulse."""
TURN = 1.5 * MOTOR.n_p**2 / (0.2 * MOTOR.J)
"""A light rotor: it turns by a third of a radian."""


def linked(i: Complex) -> Complex:
    psi = flux(MOTOR.saturation, np.stack([i.real, i.imag], axis=-1))
    return np.asarray(psi[:, 0] + 1j * psi[:, 1])


@cache
def turned(phi: float, speed: float) -> tuple[Complex, Complex]:
    """Current and flux linkage of a pulse along ``phi`` [rad], on a rotor that follows."""
    size = 1.2 * MOTOR.i_rated * np.sin(3.0 * np.pi * np.arange(N + 1) / N)
    stator: Complex = size * np.exp(1j * phi)
    theta, omega, psi = 0.0, speed, np.zeros(N + 1, complex)
    for k, now in enumerate(stator):
        psi[k] = linked(np.array([now * np.exp(-1j * theta)]))[0] * np.exp(1j * theta)
        omega += TURN * (psi[k].conjugate() * now).imag * T_S
        theta += omega * T_S
    return stator, psi


def pulse(phi: float, speed: float = 0.0, noise: float = 0.0) -> Group:
    """A pulse that swings through three lobes, as sensors with noise see it."""
    stator, psi = turned(phi, speed)
    rng = np.random.default_rng(3)
    i: Complex = stator + noise * MOTOR.i_rated * (
        rng.normal(size=N + 1) + 1j * rng.normal(size=N + 1)
    )
    u: Complex = np.asarray(np.diff(psi) / T_S)
    zero = np.zeros(N)
    small = (MOTOR.L_d, MOTOR.L_q)
    return Group(0.0, i, u, zero + MOTOR.u_dc, 0.0, np.zeros(N, complex), (0, N), small, T_S)


def pulses(speed: float = 0.0, noise: float = 0.0) -> list[Group]:
    some = [pulse(np.deg2rad(x), 0.0, noise) for x in (0, 180, 90, -90, 45, -45, 67, -67, 25)]
    return [*some, pulse(np.deg2rad(-25), speed, noise)]


@pytest.mark.parametrize("wrong", [0.7, 1.3])
def test_inertia_and_map_come_from_the_pulses_where_the_spin_is_in_doubt(wrong: float) -> None:
    psi_f = float(linked(np.zeros(1, complex))[0].real)
    off = replace(MOTOR.saturation, a_d0=0.9 * MOTOR.saturation.a_d0)
    model = replace(off, i_f=off.i_f - 0.1 * MOTOR.saturation.a_d0 * psi_f)
    found = fit_jointly(pulses(), model, psi_f, TURN / wrong, 0.3, MOTOR.i_rated)
    assert found.share == pytest.approx(wrong, rel=0.02) and found.doubt < 0.01
    again = fit_model(found.samples, psi_f, MOTOR.i_rated)
    assert max(again.rms_percent(MOTOR.i_rated)) < 0.5
    true = linked(found.samples.i) - psi_f
    assert np.abs(found.samples.psi - true).max() < 0.003 * psi_f


def test_where_the_pulses_are_in_doubt_the_spin_decides() -> None:
    psi_f = float(linked(np.zeros(1, complex))[0].real)
    stiff = 1e-4 * TURN  # hardly any turn in the fit's eyes: the pulses say nothing of it
    found = fit_jointly(pulses(noise=0.02), MOTOR.saturation, psi_f, stiff, 0.01, MOTOR.i_rated)
    assert found.doubt == pytest.approx(0.01, rel=0.1)


def test_a_group_on_a_rotor_in_motion_has_no_say() -> None:
    """40 rad/s, a radian in 24 ms: no inertia explains it."""
    psi_f = float(linked(np.zeros(1, complex))[0].real)
    found = fit_jointly(pulses(speed=40.0), MOTOR.saturation, psi_f, TURN, 0.3, MOTOR.i_rated)
    n = len(fit_jointly(pulses(), MOTOR.saturation, psi_f, TURN, 0.3, MOTOR.i_rated).samples.i)
    assert len(found.samples.i) < n
    assert found.share == pytest.approx(1.0, rel=0.01)


def test_edges_see_a_current_that_reverses_within_a_period() -> None:
    """Leg a rises before the middle with current still in, falls after it with current out."""
    stator = Stator(Sensors(), Inverter(6.0, 0.01), 0.0, T_S)
    swing = 0.5 * MOTOR.i_rated
    i = np.array([-swing, swing]) + 0j
    psi = linked(i)
    u = np.diff(psi) / T_S
    g = Group(0.0, i, u, np.array([MOTOR.u_dc]), 0.0, np.zeros(1, complex), (0, 1), (1.0, 1.0), T_S)
    lost = at_edges(g, stator, MOTOR.saturation, MOTOR.i_max).lost[0]
    assert abs(lost) < 0.05 * 6.0
    steady = replace(g, i=np.array([swing, swing]) + 0j, u=np.zeros(1, complex))
    lost = at_edges(steady, stator, MOTOR.saturation, MOTOR.i_max).lost[0]
    assert lost == pytest.approx(2.0 / 3.0 * 6.0 * (DIRECTIONS[0] - DIRECTIONS[1] - DIRECTIONS[2]))

"""The joint fit on pulses computed from a known machine, and the lost voltage at edges."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sensorless.identify.machine.details import Details, expected
from sensorless.identify.machine.edges import at_edges
from sensorless.identify.machine.electric import Complex, Inverter, Sensors, Stator
from sensorless.identify.machine.equations import Known
from sensorless.identify.machine.joint import Joint, fit_jointly
from sensorless.identify.machine.model import fit_model
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import PLACES, Group
from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
PLATE = Nameplate.of(MOTOR)
NONE = Details()
T_S = 1e-4
N = 160
"""Periods of a pulse."""
TURN = 1.5 * MOTOR.n_p**2 / (0.09 * MOTOR.J)
"""A light rotor: it turns by a third of a radian."""


def linked(i: Complex) -> Complex:
    psi = flux(MOTOR.saturation, np.stack([i.real, i.imag], axis=-1))
    return np.asarray(psi[:, 0] + 1j * psi[:, 1])


PSI_F = float(linked(np.zeros(1, complex))[0].real)
"""Magnet flux linkage [Vs]."""


@cache
def turned(
    phi: tuple[float, ...], speed: float, details: Details = NONE, place: float = 0.0
) -> tuple[Complex, Complex]:
    """(N + 1, n) currents and flux linkages of pulses along ``phi`` [rad] on rotors that follow.

    The equations of ``core/sim/harmonics.h``, in the frame of the rotor at ``place`` [rad].
    """
    size = 1.2 * MOTOR.i_rated * np.sin(3.0 * np.pi * np.arange(N + 1) / N)
    stator: Complex = np.asarray(size[:, None] * np.exp(1j * np.array(phi)))
    theta, omega = np.zeros(len(phi)), np.full(len(phi), speed)
    psi, psi_0 = np.zeros((N + 1, len(phi)), complex), linked(np.zeros(1, complex))[0]
    x = np.full(len(phi), psi_0)
    for k, now in enumerate(stator):
        six, way = np.exp(6j * (place + theta)), np.exp(1j * theta)
        m = details.m_d * six.real + 1j * details.m_q * six.imag
        e = 0.0 * now
        for _ in range(8 if details != NONE else 1):
            i = (now - details.g * e) / way
            x = linked(i - details.gamma * (x - psi_0).conj() * six)
            psi[k] = (x + m) * way
            e = 0.5 * (e + (psi[k] - psi[k - 1]) / T_S) if k else e  # half of the way closes in
        pull = (details.gamma * (x - psi_0) ** 2 * six.conj()).imag
        slope = 6.0 * (i.real * details.m_d * six.imag - i.imag * details.m_q * six.real)
        omega = omega + TURN * (((x + m).conj() * i).imag - slope - 3.0 * pull) * T_S
        theta = theta + omega * T_S
    return stator, psi


def pulse(phi: float, speed: float = 0.0, noise: float = 0.0) -> Group:
    """A pulse that swings through three lobes, as sensors with noise see it."""
    stator, psi = (x[:, 0] for x in turned((phi,), speed))
    rng = np.random.default_rng(3)
    i: Complex = stator + noise * MOTOR.i_rated * (
        rng.normal(size=N + 1) + 1j * rng.normal(size=N + 1)
    )
    return group(i, psi)


def group(i: Complex, psi: Complex, place: float = 0.0, off: float = 0.0) -> Group:
    """A pulse at ``place``, where short pulses found an axis that is ``off`` [rad]."""
    back = np.exp(-1j * off)
    return Group(
        place=place,
        theta=place + off,
        i=i * back,
        u=np.asarray(np.diff(psi) / T_S) * back,
        u_dc=np.full(N, MOTOR.u_dc),
        R_s=0.0,
        lost=np.zeros(N, complex),
        bounds=(0, N),
        small=(MOTOR.L_d, MOTOR.L_q),
        T_s=T_S,
    )


def pulses(speed: float = 0.0, noise: float = 0.0) -> list[Group]:
    some = [pulse(np.deg2rad(x), 0.0, noise) for x in (0, 180, 90, -90, 45, -45, 67, -67, 25)]
    return [*some, pulse(np.deg2rad(-25), speed, noise)]


def worst(found: Joint) -> float:
    """Largest error of the flux linkages over the magnet's."""
    return float(np.abs(found.samples.psi - (linked(found.samples.i) - PSI_F)).max() / PSI_F)


def test_the_flux_of_a_model_takes_the_measured_magnet() -> None:
    """5 % more than the model's own: 0.05 times it more at any current."""
    known = Known(MOTOR.saturation, 1.05 * PSI_F, TURN, MOTOR.i_rated)
    i: Complex = np.asarray(MOTOR.i_rated * np.array([0.0, 0.5, -0.3 + 0.8j]))
    assert known.psi(i) == pytest.approx(linked(i) + 0.05 * PSI_F)


@pytest.mark.parametrize("wrong", [0.7, 1.3])
def test_inertia_and_map_come_from_the_pulses_where_the_spin_is_in_doubt(wrong: float) -> None:
    off = replace(MOTOR.saturation, a_d0=0.9 * MOTOR.saturation.a_d0)
    model = replace(off, i_f=off.i_f - 0.1 * MOTOR.saturation.a_d0 * PSI_F)
    found = fit_jointly(pulses(), model, PSI_F, TURN / wrong, 0.3, PLATE)
    assert found.share == pytest.approx(wrong, rel=0.02) and found.doubt < 0.01
    again = fit_model(found.samples, PSI_F, MOTOR.i_rated)
    assert max(again.rms_percent(MOTOR.i_rated)) < 0.5
    assert worst(found) < 0.003


def test_the_doubt_is_over_the_inertia_that_was_found() -> None:
    """Whatever was guessed: it is what the pulses say, where the guess itself is worth nothing."""
    some = pulses(noise=0.002)
    low, high = (
        fit_jointly(some, MOTOR.saturation, PSI_F, TURN / wrong, 9.0, PLATE).doubt
        for wrong in (0.7, 1.3)
    )
    assert low == pytest.approx(high, rel=0.1)


def at_places(details: Details, off: tuple[float, float]) -> list[Group]:
    out = []
    for place, wrong in zip(PLACES, off, strict=True):
        phi = tuple(np.deg2rad((0, 180, 90, -90, 45, -45, 67, -67, 25, -25)).tolist())
        both = turned(phi, 0.0, details, place)
        out += [group(i, psi, place, wrong) for i, psi in zip(both[0].T, both[1].T, strict=True)]
    return out


def test_the_pulses_find_an_axis_that_the_short_ones_miss() -> None:
    groups = at_places(NONE, (0.01, -0.06))
    assert worst(fit_jointly(groups, MOTOR.saturation, PSI_F, TURN, 0.01, PLATE)) < 0.002


def test_harmonics_and_iron_come_apart_from_saturation() -> None:
    gamma = 0.02 * 0.5 * (1.0 / MOTOR.L_d - 1.0 / MOTOR.L_q)
    g = 0.01 * PLATE.i_rated / PLATE.u_base
    groups = at_places(Details(gamma, 0.003 * PSI_F, -0.004 * PSI_F, g), (0.0, 0.0))
    found = fit_jointly(groups, MOTOR.saturation, PSI_F, TURN, 0.01, PLATE)
    assert worst(found) < 0.003 and found.g == pytest.approx(g, rel=0.2)


def test_where_the_pulses_are_in_doubt_the_spin_decides() -> None:
    stiff = 1e-4 * TURN  # hardly any turn in the fit's eyes: the pulses say nothing of it
    for doubt in (0.01, 1e-9):  # it is never surer than 1 %
        found = fit_jointly(pulses(noise=0.02), MOTOR.saturation, PSI_F, stiff, doubt, PLATE)
        assert found.doubt == pytest.approx(0.01, rel=0.1)


def test_a_group_on_a_rotor_in_motion_has_no_say() -> None:
    """40 rad/s, a radian in 24 ms: no inertia explains it."""
    found = fit_jointly(pulses(speed=40.0), MOTOR.saturation, PSI_F, TURN, 0.3, PLATE)
    n = len(fit_jointly(pulses(), MOTOR.saturation, PSI_F, TURN, 0.3, PLATE).samples.i)
    assert n == 10 * (N + 1), "samples of up to 1.3 rated currents count"
    assert len(found.samples.i) < n
    assert found.share == pytest.approx(1.0, rel=0.01)
    two = [*pulses(speed=40.0), pulse(np.deg2rad(45), -40.0)]
    assert len(fit_jointly(two, MOTOR.saturation, PSI_F, TURN, 0.3, PLATE).samples.i) == len(
        found.samples.i
    )


def test_edges_see_a_current_that_reverses_within_a_period() -> None:
    """Leg a rises before the middle with current still in, falls after it with current out."""
    stator = Stator(Sensors(), Inverter(6.0, 0.01), 0.0, T_S)
    swing = 0.5 * MOTOR.i_rated
    i = np.array([-swing, swing]) + 0j
    psi = linked(i)
    u = np.diff(psi) / T_S
    link, zero = np.array([MOTOR.u_dc]), np.zeros(1, complex)
    g = Group(0.0, 0.0, i, u, link, 0.0, zero, (0, 1), (1.0, 1.0), T_S)
    lost = at_edges(g, stator, MOTOR.saturation, MOTOR.i_max).lost[0]
    assert abs(lost) < 0.05 * 6.0
    steady = replace(g, i=np.array([swing, swing]) + 0j, u=np.zeros(1, complex))
    lost = at_edges(steady, stator, MOTOR.saturation, MOTOR.i_max).lost[0]
    assert lost == pytest.approx(2.0 / 3.0 * 6.0 * 2.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_edges_lose_in_the_frame_of_the_stator(side: float) -> None:
    """A current along 45 degrees is into legs a and b and out of c: 4/3 of 6 V along 60."""
    stator = Stator(Sensors(), Inverter(6.0, 0.01), 0.0, T_S)
    i, u = np.full(2, 0.5 * MOTOR.i_rated, complex), np.zeros(1, complex)
    link = np.array([MOTOR.u_dc])
    g = Group(0.0, side * np.pi / 4.0, i, u, link, 0.0, u, (0, 1), (1.0, 1.0), T_S)
    lost = at_edges(g, stator, MOTOR.saturation, MOTOR.i_max).lost[0]
    assert lost == pytest.approx(8.0 * np.exp(1j * side * np.pi / 12.0), rel=1e-3)


def test_what_details_are_expected_of_a_machine() -> None:
    """5 % of the magnet over n in harmonics 5 and 7, 5 % of (20 - 10) / 2, 3 % of i / u."""
    plate = replace(PLATE, i_rated=5.63, u_dc=540.0)
    found = expected(plate, 1.0, (0.05, 0.1))
    m = 0.05 * np.sqrt(1.0 / 25.0 + 1.0 / 49.0)
    assert found.all == pytest.approx([0.25, m, m, 0.03 * 5.63 / 311.77], rel=1e-4)

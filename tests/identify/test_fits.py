"""The fits of an identification against closed forms."""

import warnings

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.identify.machine import pulses
from sensorless.identify.machine.axis import (
    Aligned,
    Axis,
    Probe,
    align_commands,
    fit_axis,
    probe_commands,
)
from sensorless.identify.machine.curves import fit_curves
from sensorless.identify.machine.electric import Inverter, Sensors, Stator
from sensorless.identify.machine.hold import fit_resistance
from sensorless.identify.machine.log import NUMBERS, Part
from sensorless.identify.machine.mechanics import NO_MECHANICS, fit_mechanics
from sensorless.identify.machine.model import fit_model
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import Samples
from sensorless.identify.machine.source import CURRENT, Recorded
from sensorless.identify.machine.spin import Point, Spin, magnet
from sensorless.identify.machine.turning import first_spin, second_spin
from sensorless.machine.magnetics import at_zero_current, currents, flux
from sensorless.machine.motor import Motor

PAPER = Motor.load("paper")
PLATE = Nameplate.of(PAPER)


def held(R: float, u_lost: float, gain: float = 1.0, ratio: float = 1.0) -> np.ndarray:
    """Means of voltage and channels at direct currents above the slope of the lost voltage."""
    i = PAPER.i_rated * np.array([1.0, 0.7, 0.4, 0.1, -0.1, -0.4, -0.7, -1.0])
    u = R * i + 4.0 / 3.0 * u_lost * np.sign(i)
    return np.stack([u, gain * i, -0.5 * gain * ratio * i], axis=-1)


@pytest.mark.parametrize("channel", [1, 2])
def test_a_current_with_the_wrong_sign_is_named(channel: int) -> None:
    means = held(2.5, 6.0)
    means[:, channel] *= -1.0
    with pytest.raises(UserError, match="one current has the wrong sign"):
        fit_resistance(means, Sensors(), PLATE)


def test_resistance_and_lost_voltage_come_apart() -> None:
    found = fit_resistance(held(2.5, 6.0), Sensors(), PLATE)
    assert found.R_s == pytest.approx(2.5, rel=1e-9)
    assert found.inverter.u_lost == pytest.approx(6.0, rel=1e-9)
    assert found.residual < 1e-9


def test_gain_errors_are_halved_but_what_is_common_is_in_the_resistance() -> None:
    found = fit_resistance(held(2.5, 6.0, gain=1.02, ratio=0.96 / 1.02), Sensors(), PLATE)
    assert found.sensors.ratio == pytest.approx(0.96 / 1.02)
    assert found.R_s == pytest.approx(2.5 / np.sqrt(1.02 * 0.96), rel=1e-9)


def test_a_source_without_resistance_is_refused() -> None:
    with pytest.raises(UserError, match="resistance"):
        fit_resistance(held(-1.0, 6.0), Sensors(), PLATE)


@pytest.mark.parametrize("theta", [-1.2, 0.0, 0.4])
def test_pulses_tell_axis_and_inductances(theta: float) -> None:
    L_d, L_q, T_s = 0.03, 0.05, 1e-4
    u = np.concatenate(
        [
            np.full(round(c.time / T_s), c.start * np.exp(1j * (c.theta or 0.0)))
            for c in probe_commands(Probe(40.0, 2), T_s)
        ]
    )
    turn = np.exp(1j * theta)
    u_dq = u / turn
    i = turn * np.r_[0.0, np.cumsum(u_dq.real / L_d + 1j * u_dq.imag / L_q)[:-1]] * T_s
    rows = np.zeros((len(u), len(NUMBERS)))
    rows[:, 1], rows[:, 2] = u.real, u.imag
    rows[:, 4], rows[:, 5] = i.real, -0.5 * i.real + 0.5 * np.sqrt(3.0) * i.imag
    found = fit_axis(Part("axis", rows), Stator(Sensors(), Inverter(), 0.0, T_s))
    assert (found.theta, found.L_d, found.L_q) == pytest.approx((theta, L_d, L_q), rel=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_alignment_ends_where_it_is_asked_to(side: float) -> None:
    """From a right angle beside it, turned as far as the speeds' means take it; u = R i + 8 V."""
    stator = Stator(Sensors(), Inverter(6.0, 0.01), 2.5, PLATE.T_s)
    commands = align_commands(stator, PLATE, 2.0, 3.0, side=side, at=0.0)
    turned = sum(0.5 * sum(c.omega) * c.time for c in commands[:3])
    assert commands[0].theta == pytest.approx(side * np.pi / 2.0)
    assert (commands[0].theta or 0.0) + turned == pytest.approx(0.0, abs=1e-9)
    assert [c.start for c in commands] == pytest.approx([13.0, 13.0, 13.0, 13.0, 0.0])
    assert commands[3].theta == pytest.approx(0.0, abs=1e-9)
    assert commands[3].time == pytest.approx(1.2)


def test_two_channels_count_as_if_their_gains_were_alike() -> None:
    """Gains of 1.1 and 0.88, offsets of 0.1 and -0.2 A: 3 A at 0.7 rad, times their mean 0.984."""
    true = 3.0 * np.exp(0.7j)
    rows = np.zeros((1, len(NUMBERS)))
    rows[0, NUMBERS.index("i_a")] = 1.1 * true.real + 0.1
    rows[0, NUMBERS.index("i_b")] = 0.88 * (true * np.exp(-2j * np.pi / 3.0)).real - 0.2
    found = Sensors((0.1, -0.2), 0.8).current(Part("hold", rows))
    assert found[0] == pytest.approx(np.sqrt(1.1 * 0.88) * true)


def test_lost_voltage_of_three_legs() -> None:
    inverter = Inverter(6.0, 0.01)
    assert inverter.lost(np.array([2.0 + 0j]))[0] == pytest.approx(8.0)
    assert inverter.lost(np.array([2.0j]))[0] == pytest.approx(6.0 * 2.0j / np.sqrt(3.0))
    assert inverter.lost(np.array([0.005 + 0j]))[0] == pytest.approx(3.0)


def measured(motor: Motor, noise: float = 0.0) -> tuple[Samples, float]:
    """Flux linkages of a machine over a disc of rated current, and its magnet flux."""
    size, angle = np.meshgrid(np.linspace(0.05, 1.0, 12), np.linspace(-np.pi, np.pi, 24))
    i = (motor.i_rated * size * np.exp(1j * angle)).ravel()
    psi = flux(motor.saturation, np.stack([i.real, i.imag], axis=-1))
    psi_f = float(flux(motor.saturation, np.zeros((1, 2)))[0, 0])
    i = i + noise * np.random.default_rng(1).normal(size=len(i))
    return Samples(i, psi[:, 0] - psi_f + 1j * psi[:, 1], 0.0, 0.0), psi_f


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w"])
def test_the_model_comes_back(name: str) -> None:
    motor = Motor.load(name)
    s, psi_f = measured(motor)
    found = fit_model(s, psi_f, motor.i_rated)
    assert max(found.rms_percent(motor.i_rated)) < 0.01
    L_d, L_q, magnet_flux = at_zero_current(found.saturation, motor.i_rated)
    assert magnet_flux == pytest.approx(psi_f)
    assert (L_d, L_q) == pytest.approx(
        at_zero_current(motor.saturation, motor.i_rated)[:2], rel=1e-3
    )


def test_noise_on_a_linear_machine_is_no_saturation() -> None:
    motor = Motor.load("ipmsm_2200w")
    s, psi_f = measured(motor, noise=0.01 * motor.i_rated)
    found = fit_model(s, psi_f, motor.i_rated).saturation
    assert (found.a_dd, found.a_qq, found.a_dq, found.a_b) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("lag", [-0.5, 0.0, 0.3])
def test_the_magnet_is_found_at_any_load_angle(lag: float) -> None:
    s, psi_f = measured(PAPER)
    curves = fit_curves(s, PAPER.i_rated)
    i = 0.4 * PAPER.i_rated * np.exp(1j * lag)
    psi = flux(PAPER.saturation, np.array([[i.real, i.imag]]))[0] @ (1.0, 1j)
    frame = np.exp(1j * 1.1)
    found = magnet(np.array([psi * frame]), np.array([i * frame]), curves)
    assert found[0] == pytest.approx(psi_f, rel=2e-3)
    assert currents(PAPER.saturation, np.array([[psi_f, 0.0]]))[0, 0] == pytest.approx(0, abs=1e-6)


def test_the_current_of_the_iron_s_loss_is_not_the_magnet_s() -> None:
    s, psi_f = measured(PAPER)
    curves = fit_curves(s, PAPER.i_rated)
    i, omega = 0.4 * PAPER.i_rated, 0.45 * PLATE.omega
    psi = flux(PAPER.saturation, np.array([[i, 0.0]]))[0] @ (1.0, 1j)
    g = 0.03 * PLATE.i_rated / PLATE.u_base
    both = np.array([i + 1j * g * omega * psi]), np.array([psi])
    spin = Spin((Point(omega, i, both, 0.0, 0.0),), NO_MECHANICS, i)
    assert spin.again(curves, g).psi_f == pytest.approx(psi_f, rel=2e-3)


def test_no_current_turns_the_rotor_beyond_the_one_that_aligns() -> None:
    aligns = 0.18 * PLATE.i_rated
    for c in (*first_spin(PLATE, aligns, 1.0), *second_spin(PLATE, PAPER.J, aligns, 1.0)):
        assert c.kind == CURRENT and max(c.start, c.end or 0.0) <= aligns


@pytest.mark.parametrize("gamma", [1e2, 1e3, 1e4])
def test_a_pulse_stays_within_the_limit_and_gets_there(gamma: float) -> None:
    """A voltage reverses up to two changes late; what holds the largest current is always left."""
    stator = Stator(Sensors(), Inverter(3.0), 1.0, PLATE.T_s)
    u, reach = pulses.voltage(gamma, stator, PLATE), 1.05 * PLATE.i_rated
    lost = 4.0 / 3.0 * stator.inverter.u_lost
    largest = reach + 2.0 * gamma * PLATE.T_s * (u - lost - stator.R_s * reach)
    settled = (u - lost) / stator.R_s
    assert settled > reach and min(largest, settled) < PLATE.i_limit


def test_inertia_comes_apart_from_friction() -> None:
    T_s, J, B, tau_0 = 1e-4, 0.01, 0.02, 0.3
    half = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 4000))
    still = np.ones(4000)
    omega = np.r_[0.0 * still, 200 * half, 200 * still, 200 - 150 * half, 50 * still]
    omega = np.r_[omega, 50 + 150 * half, 200 * still]
    segment = np.repeat(np.arange(7.0), 4000)
    speed = omega / PLATE.n_p
    tau = J * np.gradient(speed, T_s) + B * speed + tau_0
    i = np.full(len(tau), 2.0 + 0j)
    psi = 0.5 - 1j * tau / (1.5 * PLATE.n_p * 2.0)
    found = fit_mechanics(i, psi, omega, segment, PLATE, T_s)
    assert (found.J, found.B, found.tau_0) == pytest.approx((J, B, tau_0), rel=0.01)
    segment[-1] = 7.0  # a command that ended at once, at the current limit
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cut = fit_mechanics(i, psi, omega, segment, PLATE, T_s)
    assert cut.J == pytest.approx(J, rel=0.01)


def test_a_rotor_that_is_not_there_is_turned_more_slowly(monkeypatch: pytest.MonkeyPatch) -> None:
    found = iter([0.9, 0.4, 0.5, 0.5])
    monkeypatch.setattr(pulses, "fit_axis", lambda part, stator: Axis(next(found), 100.0, 50.0))
    rows = np.zeros((1, len(NUMBERS)))
    source = Recorded([Part(stage, rows) for _ in range(4) for stage in ("align", "axis")])
    aligned = Aligned(Probe(10.0, 1), 2.0, 1.0, Axis(0.0, 100.0, 50.0))
    stator = Stator(Sensors(), Inverter(), 1.0, PLATE.T_s)
    slower = [1.0, 3.0, 9.0]
    turned = [pulses.placed(source, stator, PLATE, aligned, 0.52, slower) for _ in range(2)]
    assert [axis.theta for axis in turned] == [0.5, 0.5]
    assert slower == [9.0] and len(source.parts) == 8

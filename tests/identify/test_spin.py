"""What a spin commands, which of its points count, and what they tell."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.identify.machine import spin as module
from sensorless.identify.machine.axis import Aligned, Axis, Probe
from sensorless.identify.machine.curves import fit_curves
from sensorless.identify.machine.electric import Complex, Inverter, Sensors, Stator
from sensorless.identify.machine.log import NUMBERS, Part
from sensorless.identify.machine.mechanics import Mechanics
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import Samples
from sensorless.identify.machine.source import Command, Gains
from sensorless.identify.machine.spin import Point, Spin, evaluate, flux_in_frame, measure_spin
from sensorless.identify.machine.turning import first_spin, second_spin
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

PLATE = Nameplate.of(Motor.load("paper"))
"""2 pole pairs, 14 N m at 5.63 A, 314 rad/s, 0.2 ms."""
T_S, PAPER_J = PLATE.T_s, 0.02
L_D, L_Q, PSI_F = 0.03, 0.05, 0.8
STATOR = Stator(Sensors(), Inverter(0.0), 2.0, T_S)
FOUND = Mechanics(0.02, 0.001, 0.0, 0.0, 0.0)
SOME = (np.arange(1.0, 6.0)[:, None] * np.exp(1j * np.arange(12.0))).ravel()
CURVES = fit_curves(Samples(SOME, np.asarray(L_D * SOME.real + 1j * L_Q * SOME.imag), 0, 0), 5.63)


def rows(omega: Floats, i: Complex, psi: Complex, segment: Floats) -> Part:
    """Of a machine with ``STATOR``; current and flux linkage in the frame of the drive's angle."""
    theta = np.r_[0.0, np.cumsum(omega[:-1])] * T_S
    turn = np.exp(1j * theta)
    now = i * turn
    e = psi * turn * (np.exp(1j * omega * T_S) - 1.0) / T_S
    u = e + np.r_[0.5 * STATOR.R_s * (now[1:] + now[:-1]), 0.0]
    out = np.zeros((len(omega), len(NUMBERS)))
    b = (now * np.exp(-2j * np.pi / 3.0)).real
    for name, x in (("segment", segment), ("u_alpha", u.real), ("u_beta", u.imag),
                    ("i_a", now.real), ("i_b", b), ("theta", theta), ("omega", omega)):  # fmt: skip
        out[:, NUMBERS.index(name)] = x
    return Part("spin", out)


def test_the_flux_at_a_speed_of_many_degrees_a_period() -> None:
    """800 rad/s, 9 degrees; the current swells, and each flux is that of the sample before it."""
    omega, i = np.full(50, 800.0), np.asarray(np.linspace(1.0, 5.0, 50) + 0.5j)
    psi = np.asarray(np.linspace(0.7, 0.9, 50) * np.exp(0.2j))
    found = flux_in_frame(rows(omega, i, psi, np.zeros(50)), STATOR)
    assert found[0] == pytest.approx(i[:-1]) and found[1] == pytest.approx(psi[:-1])


def held(omega: float, wave: float = 0.0) -> tuple[Floats, Complex, Complex]:
    """0.5 s at a speed with 2 A along the magnet, whose flux swings by ``wave`` over itself."""
    swing = 1.0 + wave * np.sign(np.sin(np.arange(2500) * T_S * 20.0 * np.pi))
    i = np.full(2500, 2.0 + 0j)
    return np.full(2500, omega), i, np.asarray((PSI_F + 2.0 * L_D) * swing + 0j)


def spun(*parts: tuple[Floats, Complex, Complex]) -> Part:
    omega, i, psi = (np.concatenate(x) for x in zip(*parts, strict=True))
    return rows(omega, i, psi, np.repeat(np.arange(float(len(parts))), 2500))


def test_which_points_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """At least a tenth of rated speed, within 2 % of it and 5 % of rated current."""
    monkeypatch.setattr(module, "fit_mechanics", lambda *_: FOUND)
    fast, slow, fine, way = held(100.0), held(31.0), held(32.0), held(100.0)
    drifts, swells = held(100.0), held(100.0)
    drifts[0][:] += np.linspace(0.0, 24.0, 2500)  # 7.2 rad/s from half to half of 0.3 s
    way[0][:] += np.linspace(0.0, 16.0, 2500)  # 4.8 rad/s
    swells[1][:] *= np.linspace(1.0, 1.3, 2500)  # by 0.36 A in 0.3 s
    found = evaluate(spun(fast, slow, fine, drifts, way, swells, fast), STATOR, PLATE, CURVES, 2.0)
    assert found is not None
    middle = 100.0 + 16.0 * (1.0 - 0.75 * 0.3 / 0.5)  # of the first half of the last 0.3 s
    speeds = [p.omega for p in found.points]
    assert speeds == pytest.approx([100.0, 32.0, middle, 100.0], rel=1e-3)
    assert found.psi_f == pytest.approx(PSI_F, rel=1e-6) and found.points[0].i == pytest.approx(2.0)
    # a sixth of a turn at 100 rad/s has 52 periods: 1500 of them are 28 blocks
    assert len(found.points[0].blocks[0]) == 28


@pytest.mark.parametrize(
    ("wave", "mechanics", "follows"),
    [(0.1, FOUND, True), (0.2, FOUND, False), (0.0, replace(FOUND, J_std=0.011), False)],
)
def test_whether_the_rotor_follows(
    wave: float, mechanics: Mechanics, follows: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "fit_mechanics", lambda *_: mechanics)
    part = spun(held(100.0), held(100.0, wave))
    assert (evaluate(part, STATOR, PLATE, CURVES, 2.0) is not None) == follows


def point(i: float, psi_f: float) -> Point:
    return Point(100.0, i, (np.zeros(1, complex), np.zeros(1, complex)), 0.0, psi_f)


def test_the_magnet_is_the_mean_of_the_points_that_align() -> None:
    spin = Spin((point(2.09, 0.7), point(1.0, 0.9), point(2.11, 9.0)), FOUND, 2.0)
    assert (spin.psi_f, spin.psi_f_std) == pytest.approx((0.8, 0.1))


@pytest.mark.parametrize("frame", [0.0, 0.4])
def test_the_current_of_the_iron_is_taken_out(frame: float) -> None:
    """1 A of it across an EMF of 300 V; with the wrong sign, it would be 2 A in q."""
    turn = np.exp(1j * frame)
    psi = np.array([PSI_F + L_D * 1.5 + 1j * L_Q * 1.0])
    g = 1.0 / (300.0 * abs(psi[0]))
    i = np.array([1.5 + 1.0j]) + 1j * g * 300.0 * psi
    spin = Spin((Point(300.0, 1.8, (i * turn, psi * turn), 0.0, 0.0),), FOUND, 2.0)
    assert spin.again(CURVES, g).psi_f == pytest.approx(PSI_F, rel=1e-6)


@pytest.mark.parametrize(("aligns", "share"), [(9.0, 1.0), (0.25 * 5.63, 0.5)])
@pytest.mark.parametrize("careful", [1.0, 3.0])
def test_what_a_second_spin_commands(aligns: float, share: float, careful: float) -> None:
    """Ramps take 12 % of rated torque where they are steepest, less where less current aligns.

    They rise as half a cosine does, by pi/2 of their mean slope. 40 % of rated torque a radian
    holds the rotor.
    """
    J, stiff = 2.0, 0.4 * 14.0 * share
    swing = np.sqrt(2.0 * stiff / J)
    told = second_spin(PLATE, J, aligns, careful)
    rise, rest, up, hold, down, *_, last = told
    high, low = 0.45 * 314.16, 0.2 * 314.16
    for c, change in ((up, high), (down, high - low), (last, high)):
        steepest = 0.5 * np.pi * change / c.time
        assert J * steepest / PLATE.n_p == pytest.approx(0.12 * 14.0 * share / careful, rel=1e-3)
    speeds = [*up.omega, *down.omega, *last.omega]
    assert speeds == pytest.approx([0.0, high, high, low, high, 0.0], rel=1e-4)
    current = 0.5 * 5.63 * share
    assert hold.start == pytest.approx(current)
    assert (rise.start, rise.end, rest.start) == pytest.approx((0.0, current, current))
    assert rise.theta == 0.0 and rest.time == pytest.approx(0.3)
    assert hold.time == pytest.approx(3.0 * 2.0 * np.pi / swing)
    # torque over the EMF's share along the current: 1 V for tau / (3/2 n_p i) omega
    assert hold.damp == pytest.approx(swing * 3.0 * current / (high * stiff), rel=1e-3)
    assert hold.follow == pytest.approx(0.2 * swing * T_S)


def test_a_second_spin_s_current_is_steady_and_has_three_sizes() -> None:
    """That of the ramps, 2.815 A, and 0.8 and 0.6 of the 5 A that align, at both speeds."""
    told = second_spin(PLATE, PAPER_J, 5.0, 1.0)
    ends = [c.start if c.end is None else c.end for c in told]
    assert [c.start for c in told[1:]] == pytest.approx(ends[:-1])
    for share in (0.2, 0.45):
        held = [c for c in told if c.omega == pytest.approx((share * 314.16,) * 2, rel=1e-4)]
        sizes = {round(c.start, 3) for c in held if c.end is None}
        assert sizes == {2.815, 4.0, 3.0}


def test_a_light_rotor_has_time_to_swing() -> None:
    """Four swings a ramp, or three times as many; 3.2 turns at a speed, at least 0.4 s."""
    J = 1e-5
    swing = np.sqrt(2.0 * 0.4 * 14.0 / J)
    for careful in (1.0, 3.0):
        up = second_spin(PLATE, J, 9.0, careful)[2]
        assert up.time == pytest.approx(4.0 * careful * 2.0 * np.pi / swing)
    hold = first_spin(replace(PLATE, n_rated_rpm=100.0), 9.0, 1.0)[3]
    assert hold.time == pytest.approx(3.2 / (0.2 * 2.0 * 100.0 / 60.0))
    assert first_spin(PLATE, 9.0, 1.0)[3].time == pytest.approx(0.4)


def test_a_first_spin_takes_the_rotor_for_one_that_needs_a_fifth_of_a_second() -> None:
    """14 N m bring 157 rad/s in 0.2 s."""
    swing = np.sqrt(2.0 * 0.4 * 14.0 / (0.2 * 14.0 / 157.08))
    up = first_spin(PLATE, 9.0, 3.0)[2]
    assert up.time == 3.0 and up.follow == pytest.approx(0.2 * swing * T_S, rel=1e-3)


class Bench:
    """Remembers what it was told to run."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.told: list[tuple[str, list[Command], Gains | None]] = []

    def run(self, stage: str, commands: Sequence[Command], gains: Gains | None = None) -> Part:
        self.told.append((stage, list(commands), gains))
        return Part(stage, np.zeros((1, len(NUMBERS))))


@pytest.mark.parametrize(
    ("answers", "said"),
    [("nfnf", ""), ("nnn", "does not follow a slowly"), ("fnn", "falls out of step")],
)
def test_what_fails_is_tried_more_slowly(
    answers: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = Spin((point(1.0, 0.8),), FOUND, 2.0)
    left = iter(answers)
    monkeypatch.setattr(module, "evaluate", lambda *_: good if next(left) == "f" else None)
    aligned = Aligned(Probe(9.0, 1), 2.0, 1.0, Axis(0.0, 62.5, 37.5))
    bench = Bench()
    if said:
        with pytest.raises(UserError, match=said):
            measure_spin(bench, STATOR, PLATE, CURVES, aligned)
        return
    assert measure_spin(bench, STATOR, PLATE, CURVES, aligned) is good
    tried = [commands for stage, commands, _ in bench.told if stage != "align"]
    spins = [second_spin(PLATE, 0.02, 2.0, careful) for careful in (1.0, 3.0)]
    assert tried == [first_spin(PLATE, 2.0, 1.0), first_spin(PLATE, 2.0, 3.0), *spins]
    gains = bench.told[1][2]
    assert gains is not None and gains.L == pytest.approx(0.02), "of 10 and 40 mH"
    assert gains.bandwidth == pytest.approx(300.0) and gains.R == 2.0

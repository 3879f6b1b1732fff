"""What pulses of an identification command, and the flux linkages that they tell."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.identify.machine import pulses
from sensorless.identify.machine.axis import Aligned, Axis, Probe, align_commands
from sensorless.identify.machine.electric import Complex, Inverter, Sensors, Stator
from sensorless.identify.machine.log import NUMBERS, Part
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.pulses import PLACES, Group, measure_pulses, samples, voltage
from sensorless.identify.machine.source import Command
from sensorless.machine.motor import Motor

PLATE = replace(
    Nameplate.of(Motor.load("paper")),
    i_rated=10.0, u_dc=300.0 * 3.0**0.5, T_s=1e-4, i_trip=20.0, adc_range=25.0,
)  # fmt: skip
"""300 V of a phase, tests stop at 19.6 A, pulses reach 10.5 A."""
L_D, L_Q, PSI_F = 0.03, 0.05, 0.8
TURN = 3000.0
"""Of a rotor [rad/s^2 per V s A]."""


def stator(R_s: float, u_lost: float) -> Stator:
    return Stator(Sensors(), Inverter(u_lost), R_s, PLATE.T_s)


@pytest.mark.parametrize(
    ("gamma", "R_s", "u_lost", "u"),
    [
        (100.0, 0.5, 1.0, 0.1 * 10.0 / 100.0 / 1e-4),  # a tenth of rated current in a period
        (300.0, 1.0, 3.0, 4.0 * 10.0 + 2.0 * 3.0),  # fast, over four times what holds it
        (1000.0, 1.0, 3.0, (19.6 - 10.5) / 3.0 / 0.1),  # room for three changes to the limit
        (5000.0, 2.0, 3.0, 1.25 * (2.0 * 10.5 + 4.0 / 3.0 * 3.0)),  # what gets there at all
        (10.0, 0.5, 1.0, 0.9 * 300.0),  # most that the inverter has
    ],
)
def test_the_voltage_of_a_pulse(gamma: float, R_s: float, u_lost: float, u: float) -> None:
    assert voltage(gamma, stator(R_s, u_lost), PLATE) == pytest.approx(u)


class Bench:
    """Remembers what it was told to run."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.told: list[tuple[str, list[Command]]] = []

    def run(self, stage: str, commands: Any, gains: object = None) -> Part:
        del gains
        self.told.append((stage, list(commands)))
        rows = np.zeros((4 * len(self.told[-1][1]), len(NUMBERS)))
        rows[:, 0] = np.repeat(np.arange(len(self.told[-1][1])), 4)
        rows[:, NUMBERS.index("i_a")] = 2.0
        rows[:, NUMBERS.index("i_b")] = -1.0
        rows[:, NUMBERS.index("u_alpha")] = 50.0
        rows[:, NUMBERS.index("u_dc")] = 500.0 + np.arange(len(rows))
        self.parts.append(Part(stage, rows))
        return self.parts[-1]


def test_what_is_run_in_each_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    """The axis is found half a turn and 0.02 rad off; the slope lies between both axes' by 2 phi.

    Lobes of 0.71, 1, 0.71 and almost 0 of 10.5 A, each the other way than the last.
    """
    bench, off = Bench(), np.pi + 0.02
    g_d, g_q = 10.0 / L_D, 10.0 / L_Q
    mean, half = 0.5 * (g_d + g_q), 0.5 * (g_d - g_q)
    turns = iter([at for at in PLACES for _ in range(8)])
    monkeypatch.setattr(pulses, "fit_axis", lambda *_: Axis(next(turns) + off, mean, half))
    aligned = Aligned(Probe(10.0, 1), 2.0, 1.5, Axis(0.0, mean, half))
    now = stator(0.5, 3.0)
    groups = measure_pulses(bench, now, PLATE, aligned)
    assert [g.place for g in groups] == pytest.approx([np.pi / 12.0] * 8 + [-np.pi / 12.0] * 8)
    assert bench.told[0] == ("align", align_commands(now, PLATE, 2.0, 1.5, at=PLACES[0]))
    told = [commands for stage, commands in bench.told if stage == "pulse"]
    assert len(told) == 16 and len(bench.told) == 48, "no turn is repeated"
    for phi, slope, u, c in ((0, g_d, 30.0, told[0][:4]), (90, g_q, 50.0, told[1][:4]),
                             (45, mean, 37.5, told[2][:4])):  # fmt: skip
        assert voltage(slope, now, PLATE) == pytest.approx(u)
        assert [x.start for x in c] == pytest.approx([u, -u, u, -u])
        assert [x.until for x in c] == pytest.approx([10.5 * 0.5**0.5, 10.5, 10.5 * 0.5**0.5, 0.01],
                                                     rel=0.06)  # fmt: skip
        assert [x.theta for x in c] == pytest.approx([PLACES[0] + off + np.deg2rad(phi)] * 4)
        swing = 10.5 * (1.0 + 0.5**0.5)
        assert min(x.time for x in c) > 2.0 * swing / (slope * u), "also at half the slope"
    assert [len(commands) for commands in told[:3]] == [9, 9, 5]
    assert all(commands[-1].start == 0.0 and not commands[-1].until for commands in told)
    # 2 A along phase a lose 4/3 of 3 V, and all is seen from the axis
    back = np.exp(-1j * (PLACES[0] + off))
    assert groups[0].lost == pytest.approx(4.0 * back) and groups[0].i == pytest.approx(2.0 * back)
    assert groups[0].path[1] == pytest.approx((50.0 - 4.0 - 1.0) * 1e-4 * back)
    assert groups[0].bounds == (0, 16, 32)
    assert groups[0].u_dc == pytest.approx(500.0 + np.arange(32.0)), (
        "after each sample but the last"
    )
    assert groups[0].small == pytest.approx((1.0 / g_d, 1.0 / g_q))


def test_a_slower_turn_takes_its_factor() -> None:
    """The rotor is 90 degrees off each time; the last factor is taken as it is."""
    bench, now = Bench(), stator(1.0, 0.0)
    aligned = Aligned(Probe(10.0, 1), 2.0, 1.5, Axis(0.0, 26.0, 6.0))
    slower = [1.0, 3.0, 9.0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pulses, "fit_axis", lambda *_: Axis(np.pi / 2.0, 26.0, 6.0))
        pulses.placed(bench, now, PLATE, aligned, 0.0, slower)
    aligns = [commands for stage, commands in bench.told if stage == "align"]
    assert aligns == [align_commands(now, PLATE, 2.0, 1.5 * x, at=0.0) for x in (1.0, 3.0, 9.0)]


def turned(phi: float, turn: float, lost: float = 0.0) -> Group:
    """A pulse along ``phi`` [rad] on a rotor with L_D and L_Q that follows the torque.

    ``lost``: flux that is missing at the end [Vs].
    """
    n = 160
    size = 10.0 * np.sin(3.0 * np.pi * np.arange(n + 1) / n) + 1.0
    i: Complex = np.asarray(size * np.exp(1j * phi))
    psi, theta, omega = np.zeros(n + 1, complex), 0.0, 0.0
    for k in range(n + 1):
        x = i[k] * np.exp(-1j * theta)
        psi[k] = (PSI_F + L_D * x.real + 1j * L_Q * x.imag) * np.exp(1j * theta)
        omega += turn * (psi[k].conjugate() * i[k]).imag * PLATE.T_s
        theta += omega * PLATE.T_s
    drift = lost * np.linspace(0.0, 1.0, n + 1)
    u: Complex = np.asarray(np.diff(psi + drift) / PLATE.T_s)
    zero = np.zeros(n, complex)
    return Group(0.0, 0.0, i, u, np.full(n, 500.0), 0.0, zero, (0, n), (L_D, L_Q), PLATE.T_s)


@pytest.mark.parametrize("phi", [0.0, 0.8, -0.8, np.pi / 2.0])
def test_the_flux_of_a_rotor_that_turns(phi: float) -> None:
    """Up to 0.2 rad; the map is that of the inductances, in the rotor's own frame."""
    found = samples([turned(phi, TURN)], PSI_F, TURN)
    right = L_D * found.i.real + 1j * L_Q * found.i.imag
    assert found.psi == pytest.approx(right, abs=2e-3 * PSI_F)
    assert (found.turned > 0.05) == (phi != 0.0)


def test_a_group_that_does_not_come_back_is_left_out() -> None:
    """What is missing of 8, over a third of the median's in the others, and over 5 % of the flux.

    The largest flux of a pulse along d is L_d times 10 A.
    """
    good, little, bad = (turned(0.0, 0.0, x * 10.0 * L_D) for x in (0.0, 0.04, 0.06))
    n = len(good.i)
    found = samples([good, little, good], PSI_F, 0.0)
    assert len(found.i) == 3 * n
    assert found.left == pytest.approx(0.04 / np.sqrt(3.0), rel=0.1)
    assert len(samples([good, bad, good], PSI_F, 0.0).i) == 2 * n
    assert len(samples([bad, bad, good], PSI_F, 0.0).i) == 3 * n, "three times the median"

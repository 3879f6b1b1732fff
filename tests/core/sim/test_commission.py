"""Test commands of a commissioning run against closed forms of a winding at rest."""

import numpy as np
import pytest

from sensorless.core.api import Array
from sensorless.core.machine import COMMISSION_NAMES
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.steady import make_ideal
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.simulated import Simulated
from sensorless.identify.machine.source import Gains, amps, volts
from sensorless.machine.motor import Motor

MOTOR = Motor.load("ipmsm_2200w")
"""Linear."""


def blocked(monkeypatch: pytest.MonkeyPatch, theta: float) -> Simulated:
    """Ideal sensors and inverter, the rotor locked at theta."""
    build = SimFactory.build

    def locked(self: SimFactory, s: Scenarios, **more: bool) -> Array:
        sims = build(self, s, **more)  # type: ignore[arg-type]
        make_ideal(sims)
        sims["plant"]["inv_J"] = 0.0
        return sims

    monkeypatch.setattr(SimFactory, "build", locked)
    s = Scenarios.nominal(MOTOR, np.array([1], np.uint64), 1.0)
    s.theta_0[:] = theta
    return Simulated(MOTOR, s)


@pytest.mark.parametrize(("theta", "L"), [(0.0, MOTOR.L_d), (0.5 * np.pi, MOTOR.L_q)])
def test_a_step_rises_as_a_winding_does(
    monkeypatch: pytest.MonkeyPatch, theta: float, L: float
) -> None:
    part = blocked(monkeypatch, theta).run("hold", [volts(0.02, 20.0)])
    t = MOTOR.T_s * (np.arange(len(part.rows)) - 1)  # the command acts a period later
    wanted = 20.0 / MOTOR.R_s * (1.0 - np.exp(-np.maximum(t, 0.0) * MOTOR.R_s / L))
    assert part["i_a"] == pytest.approx(wanted, abs=2e-5 * wanted[-1])
    assert part["i_b"] == pytest.approx(-0.5 * wanted, abs=2e-5 * wanted[-1])
    assert part["u_alpha"][0] == 0.0 and np.all(part["u_alpha"][1:] == 20.0)


def test_a_command_ends_at_its_current(monkeypatch: pytest.MonkeyPatch) -> None:
    source = blocked(monkeypatch, 0.0)
    part = source.run("pulse", [volts(1.0, -50.0, until=2.0), volts(0.001, 0.0)])
    first = part["segment"] == 0
    assert np.all(part["i_a"][first] > -2.0) and part["i_a"][~first][0] <= -2.0


def test_the_current_control_holds_a_turning_current(monkeypatch: pytest.MonkeyPatch) -> None:
    source = blocked(monkeypatch, 0.0)
    gains = Gains(MOTOR.R_s, np.sqrt(MOTOR.L_d * MOTOR.L_q), 0.06 / MOTOR.T_s)
    part = source.run("spin", [amps(1.0, 1.5, 0.3, omega=(1.0, 1.0))], gains)
    i = part["i_a"] + 1j * (part["i_a"] + 2.0 * part["i_b"]) / np.sqrt(3.0)
    assert part["theta"][-1] == pytest.approx(0.3 + 1.0 - MOTOR.T_s, abs=1e-3)
    assert (i * np.exp(-1j * part["theta"]))[-1] == pytest.approx(1.5, abs=0.01)


def test_too_much_current_stops_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    source = blocked(monkeypatch, 0.0)
    with pytest.raises(ValueError, match="current above"):
        source.run("hold", [volts(1.0, 0.5 * MOTOR.u_dc)])
    assert len(source.parts[0].rows) < 0.5 / MOTOR.T_s


def test_columns_are_those_of_the_log() -> None:
    from sensorless.identify.machine.log import NUMBERS

    assert COMMISSION_NAMES == NUMBERS
    assert Nameplate.of(MOTOR).n_p == MOTOR.n_p

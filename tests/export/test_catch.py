"""The speed at which an export's README lets a shaft spin is one at which the drive catches it."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.export.start import FLYING, spin_text
from sensorless.machine.motor import Motor
from sensorless.observers import start_design
from sensorless.units import RPM_TO_RAD_S

FAST = Path(__file__).parents[1] / "data" / "traction_150kw.toml"
"""Its EMF takes 0.7 of the voltage at rated speed, and its inductance is small."""

SPINDLE = Path(__file__).parents[1] / "data" / "spindle_50khz.toml"
"""Its weak magnets let the voltage reach 8660 rad/s, electrical."""


def started(motor: Motor, rpm: float) -> Array:
    """States of 40 drives that have been starting for 30 ms on a shaft this fast, either way."""
    n = 40
    s = Scenarios.nominal(motor, combine(3, np.arange(n)), 1.0)
    s.seek[:], s.theta_0, s.noise[:] = True, np.linspace(-3.1, 3.1, n), 0.005
    s.omega_0 = np.where(np.arange(n) % 2 == 0, rpm, -rpm) * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, DriveDesign()).build(s)
    k_s, obs = np.zeros(n, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, round(0.03 / motor.T_s), k_s, obs)
    return np.asarray(sims["drive"]["x"])


def over_current(motor: Motor, rpm: float) -> bool:
    """Whether any of them asks for an open bridge."""
    return bool((started(motor, rpm)["fault"] & lib.FAULT_OVER_CURRENT).any())


def promised(motor: Motor) -> tuple[float, float]:
    """Speed [r/min] and share of the voltage that the README says."""
    found = re.search(r"at up to\n(\d+) r/min, .* ([\d.]+) of the", spin_text(motor, DriveDesign()))
    assert found is not None
    return float(found[1]), float(found[2])


def test_a_fast_machine_is_promised_what_its_drive_catches() -> None:
    """At 0.9 of the voltage, 5989 r/min, the EMF drives too much current before it is known."""
    motor = Motor.load(str(FAST))
    rpm, share = promised(motor)
    assert over_current(motor, rpm * FLYING / share)
    assert not over_current(motor, rpm)
    assert 5000.0 < rpm < 5600.0


def test_where_the_voltage_is_the_limit_all_of_it_is_promised(motor: Motor) -> None:
    assert promised(motor) == (1349.0, FLYING)
    assert not over_current(motor, 1349.0)


def test_the_speed_of_a_fast_shaft_is_found_from_none() -> None:
    """An EMF that is followed in 1.25 ms ends at a wrong speed, and half a turn off the rotor."""
    motor = Motor.load(str(SPINDLE))
    rpm, share = promised(motor)
    assert share == FLYING
    found = started(motor, rpm)["est"]["omega"] / motor.n_p / RPM_TO_RAD_S
    assert np.abs(np.abs(found) / rpm - 1.0).max() < 0.02


def test_a_speed_that_comes_out_wrong_is_not_promised(monkeypatch: pytest.MonkeyPatch) -> None:
    motor = replace(Motor.load(str(SPINDLE)), J=2.1e-4)
    monkeypatch.setattr(start_design, "emf_time", lambda _: 1.25e-3)
    assert promised(motor)[1] <= 0.65

"""The speed at which an export's README lets a shaft spin is one at which the drive catches it."""

import re
from pathlib import Path

import numpy as np

from sensorless.core.api import SIGNAL_N, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.export.start import FLYING, spin_text
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

FAST = Path(__file__).parents[1] / "data" / "traction_150kw.toml"
"""Its EMF takes 0.7 of the voltage at rated speed, and its inductance is small."""


def over_current(motor: Motor, rpm: float) -> bool:
    """Whether any drive that starts on a shaft this fast asks for an open bridge."""
    n = 40
    s = Scenarios.nominal(motor, combine(3, np.arange(n)), 1.0)
    s.seek[:], s.theta_0, s.noise[:] = True, np.linspace(-3.1, 3.1, n), 0.005
    s.omega_0 = np.where(np.arange(n) % 2 == 0, rpm, -rpm) * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, DriveDesign()).build(s)
    k_s, obs = np.zeros(n, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, round(0.03 / motor.T_s), k_s, obs)
    return bool((sims["drive"]["x"]["fault"] & lib.FAULT_OVER_CURRENT).any())


def promised(motor: Motor) -> tuple[float, float]:
    """Speed [r/min] and share of the voltage that the README says."""
    found = re.search(r"at up to\n(\d+) r/min, .* ([\d.]+) of the", spin_text(motor, DriveDesign()))
    assert found is not None
    return float(found[1]), float(found[2])


def test_a_fast_machine_is_promised_what_its_drive_catches() -> None:
    """At 0.9 of the voltage, 5989 r/min, the EMF drives more than the limit before it is known."""
    motor = Motor.load(str(FAST))
    rpm, share = promised(motor)
    assert over_current(motor, rpm * FLYING / share)
    assert not over_current(motor, rpm)
    assert 4000.0 < rpm < 4700.0


def test_where_the_voltage_is_the_limit_all_of_it_is_promised(motor: Motor) -> None:
    assert promised(motor) == (1349.0, FLYING)
    assert not over_current(motor, 1349.0)

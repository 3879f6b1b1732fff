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

FAST = """
name = "fast"
description = "150 kW traction machine whose EMF is 0.7 of the voltage at rated speed"
[machine]
n_p = 4
R_s = 0.007
L_d = 0.00013
L_q = 0.00035
psi_f = 0.16569
J = 0.13509
B = 0.0067547
[rating]
tau_rated = 318.31
i_rated = 367.7
n_rated_rpm = 4500.0
u_dc = 800.0
[saturation]
a_d0 = 6153.84615
a_dd = 408241.96
S = 4
a_q0 = 2142.85714
a_qq = 10360.6
T = 1
a_dq = 52035.8
U = 0
V = 0
i_f = 1070.7
[drive]
T_s = 0.0001
u_inj = 34.0
i_max = 551.54
i_trip = 1103.1
dead_time = 2e-06
adc_range = 735.39
adc_bits = 12
"""


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


def test_a_fast_machine_is_promised_what_its_drive_catches(tmp_path: Path) -> None:
    """At 0.9 of the voltage, 5989 r/min, the EMF drives more than the limit before it is known."""
    path = tmp_path / "fast.toml"
    path.write_text(FAST, encoding="utf-8")
    motor = Motor.load(str(path))
    rpm, share = promised(motor)
    assert over_current(motor, rpm * FLYING / share)
    assert not over_current(motor, rpm)
    assert 4000.0 < rpm < 4700.0


def test_where_the_voltage_is_the_limit_all_of_it_is_promised(motor: Motor) -> None:
    assert promised(motor) == (1349.0, FLYING)
    assert not over_current(motor, 1349.0)

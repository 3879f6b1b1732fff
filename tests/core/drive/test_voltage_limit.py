"""The drive where its DC link ends: loads and references beyond rated speed."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import TRACE_NAMES, sim_trace
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy


@pytest.mark.parametrize("inertia", [0.55, 0.7, 1.0, 1.7])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_braking_beyond_rated_speed_does_not_slip(inertia: float, way: float) -> None:
    """A driving load of rated torque within 2 ms, at rated speed.

    The flux that the voltage allows falls as the speed rises. A drive that asks for its torque
    nevertheless loses the current: torque, sensored or not, runs to several times rated, then the
    current limit trips.
    """
    motor = Motor.load("pmsyrm_5600w")
    s = Scenarios.nominal(motor, np.array([1], dtype=np.uint64), 0.8)
    s.omega_0[:] = way * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1], s.tau[:, 1:] = 0.2, -way * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.002
    s.J[:] = inertia
    sim = SimFactory(motor, DriveDesign(estimator="coupled")).build(s)
    trace = sim_trace(sim, int(sim["k_end"][0]), 0.0)
    column = {name: trace[:, j] for j, name in enumerate(TRACE_NAMES)}
    assert sim["lost"][0] == 0
    for who in ("tau", "tau_twin"):
        assert np.max(np.abs(column[who])) < 2.0 * motor.tau_rated


@pytest.mark.parametrize(("name", "share", "load"), [("paper", 2.0, 0.2), ("ebike_hub", 2.2, 0.0)])
def test_a_reference_beyond_what_the_voltage_allows(name: str, share: float, load: float) -> None:
    """A step to it ends where a slow ramp ends, in lock and without an alarm.

    A torque current that only waits for field weakening, which is at its end, leaves the drive at a
    lower speed for good, with a current far from its reference.
    """
    motor = Motor.load(name)
    ends = []
    for ramp in (None, motor.n_rated_rpm):
        plan = plan_from(
            f"0:{share * motor.n_rated_rpm}", f"0:{load * motor.tau_rated}", ramp, 5.0, motor, 1
        )
        run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
        assert not run["lost"].any() and not run["alarm"].any()
        assert np.degrees(np.abs(run["theta_e_err"])).max() < 20.0
        ends.append(run["omega_m"][-1] * motor.n_p / motor.omega_rated)
    assert ends[0] == pytest.approx(ends[1], abs=0.01)
    assert ends[0] < share - 0.1


SMALL = """
name = "small"
description = "100 W at 4000 r/min, much resistance, linear: made up"
[machine]
n_p = 7
R_s = 0.12
L_d = 6e-5
L_q = 9e-5
psi_f = 0.0032636
J = 2.5e-5
B = 5.7e-6
[rating]
tau_rated = 0.23873
i_rated = 7.3539
n_rated_rpm = 4000.0
u_dc = 24.0
[drive]
T_s = 5e-5
u_inj = 0.55
i_max = 11.031
i_trip = 22.062
dead_time = 5e-7
adc_range = 14.708
adc_bits = 12
"""


@pytest.mark.parametrize("load", [-0.1, -0.3])
def test_braking_from_beyond_rated_speed_ends_at_rest(tmp_path: Path, load: float) -> None:
    """Where resistance takes much of the voltage, a generator's torque current lowers the voltage.

    A drive that lets it give way as it does a motor's stays up there for as long as a load of a
    tenth drives the shaft, whatever the reference.
    """
    path = tmp_path / "small.toml"
    path.write_text(SMALL, encoding="utf-8")
    motor = Motor.load(path)
    plan = plan_from("0:8000,1.1:0", f"0:0,0.8:{load * motor.tau_rated}", 13333.0, 3.0, motor, 1)
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    assert not run["lost"].any()
    assert abs(run["omega_m"][-1]) < 0.01 * motor.omega_m_rated


@pytest.mark.parametrize("load", [-0.1, 0.0, 0.1])
@pytest.mark.parametrize("share", [1.7, 2.0])
def test_a_step_down_from_far_beyond_rated_speed(share: float, load: float) -> None:
    """A reluctance machine brakes from there without running into its current limit.

    Short of voltage the flux falls behind the rotor, the d current runs away beyond its reference
    and with it the generator's torque, unless its torque current gives way.
    """
    motor = Motor.load("pmsyrm_5600w")
    n = motor.n_rated_rpm
    plan = plan_from(
        f"0:{share * n},1.1:{0.5 * n}", f"0:{load * motor.tau_rated}", None, 2.2, motor, 1
    )
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    assert not run["lost"].any() and not run["alarm"].any()
    assert run["omega_m"][-1] == pytest.approx(0.5 * motor.omega_m_rated, rel=0.01)


@pytest.mark.parametrize("name", ["paper", "pmsyrm_5600w", "brusa_hsm1"])
@pytest.mark.parametrize("share", [1.9, 2.2])
def test_a_drive_comes_down_from_beyond_its_voltage_limit(name: str, share: float) -> None:
    """However little resistance it has.

    Friction alone is less than the torque that an angle error of a degree makes there.
    """
    motor = Motor.load(name)
    n = share * motor.n_rated_rpm
    for inertia in (0.6, 1.0, 1.7):
        plan = plan_from(f"0:{n},2.8:0", "0:0", 1.5 * motor.n_rated_rpm, 6.0, motor, 1)
        plan.J[:] = inertia
        run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
        assert not run["lost"].any() and not run["fault"].any()
        assert abs(run["omega_m"][-1]) < 0.01 * motor.omega_m_rated, inertia

"""Gains from the machine: closed forms, limits, and what a user gives wins."""

import math
import re
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.derived import DIP, LOOP_SHARE, MUCH_DIP, back_after, derive, load_dip
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import family
from sensorless.machine.magnetics import apparent_q_inductance, flux, inverse_inductance, mtpa
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.observers.tracking import (
    LEAST_DEAD_TIME,
    dead_time_noise,
    flux_noise,
    tracking,
)

PAPER = Motor.load("paper")
SHIPPED = sorted(path.stem for path in MOTORS.glob("*.toml"))
MACHINES = [*map(Motor.load, SHIPPED), *family(1, 16)]
PAGE = Path(__file__).parents[2] / "docs/gains.md"


@pytest.mark.parametrize("motor", MACHINES, ids=lambda m: m.name)
def test_the_current_loop_keeps_45_degrees_with_the_smallest_inductance(motor: Motor) -> None:
    """Integrator of bandwidth 2 alpha r and a delay of 1.5 periods: margin pi/2 - 3 alpha r T_s."""
    line = mtpa(motor)
    designed = apparent_q_inductance(motor, np.array([[0.0, 0.5 * motor.i_rated]]))[0]
    steep = inverse_inductance(motor.saturation, flux(motor.saturation, line))[:, 1, 1].max()
    turn = 3.0 * 2.0 * math.pi * derive(motor, DriveDesign()).current_hz * motor.T_s
    assert math.degrees(math.pi / 2.0 - turn * max(1.0, designed * steep)) > 44.9


def test_a_rated_load_dips_the_speed_as_asked() -> None:
    """IP loop on the inertia alone: the dip after a step of the load is ``DIP`` of rated speed."""
    light = replace(Motor.load("ipmsm_2200w"), speed_hz=None)
    w = 2.0 * math.pi * derive(light, DriveDesign()).speed_hz
    t = np.linspace(0.0, 10.0 / w, 20001)
    dip = light.tau_rated / light.J * t * np.exp(-w * t)  # impulse response of s / (s + w)^2
    share = dip * light.n_p / light.omega_rated
    assert share.max() == pytest.approx(DIP, rel=1e-3)
    beyond = t[share > 0.02].max()
    assert back_after(light, load_dip(light, w), 0.02) == pytest.approx(beyond, rel=1e-3)


def test_without_torque_the_flux_is_followed_fast_enough_for_the_speed_loop() -> None:
    """On a servo whose dead time makes noise the loop is slower, as far as the dip allows it."""
    servo = replace(
        PAPER, n_p=5, R_s=1.1, L_d=3.2e-3, L_q=4.6e-3, psi_f=0.036, J=1.6e-4, u_dc=310.0,
        tau_rated=1.27, i_rated=3.6, n_rated_rpm=3000.0, u_inj=40.0, i_max=7.5, adc_range=16.0,
        saturation=Saturation.linear(3.2e-3, 4.6e-3, 0.036), T_s=1e-4,
    )  # fmt: skip
    for dead_time, counts in ((0.0, False), (0.5e-6, False), (1.2e-6, True)):
        m = replace(servo, dead_time=dead_time)
        by, noisier = derive(m, DriveDesign()), dead_time_noise(m) / flux_noise(m)
        assert by.coupled_flux_hz / by.speed_hz == pytest.approx(max(18.0, 9.0 * noisier))
        assert counts == (noisier > 2.0)
    for J in (1.6e-4, 0.3e-4):  # at the dip, and beyond it with any loop
        m = replace(servo, J=J, dead_time=2.5e-6)
        w = 2.0 * math.pi * derive(m, DriveDesign()).speed_hz
        assert load_dip(m, w) == pytest.approx(
            max(MUCH_DIP, load_dip(m, LOOP_SHARE * tracking(m, flux_noise(m))))
        )


@pytest.mark.parametrize("motor", MACHINES, ids=lambda m: m.name)
def test_every_number_is_in_the_range_of_its_setting(motor: Motor) -> None:
    """So that what is derived can be given, and gives the same."""
    values = asdict(derive(motor, DriveDesign()))
    assert asdict(derive(motor, DriveDesign(**values))) == values


def test_noise_slows_and_acceleration_quickens() -> None:
    """W^3 = a / (sigma sqrt(T_s)): twice the converter step, or an eighth of the inertia."""
    base, coarse, light = (
        derive(m, DriveDesign())
        for m in (PAPER, replace(PAPER, adc_range=8.0 * PAPER.adc_range),
                  replace(PAPER, J=PAPER.J / 8.0))
    )  # fmt: skip
    for name in ("hfi_pll_hz", "smo_pll_hz", "flux_pll_hz", "error_pll_hz"):
        assert getattr(coarse, name) == pytest.approx(0.5 * getattr(base, name))
        assert getattr(light, name) == pytest.approx(2.0 * getattr(base, name))


def test_what_is_given_wins() -> None:
    """The design over the motor file, the motor file over the formula."""
    own = replace(PAPER, speed_hz=1.5)
    assert derive(own, DriveDesign()).speed_hz == 1.5
    assert derive(own, DriveDesign(speed_hz=4.0)).speed_hz == 4.0
    slope = derive(own, DriveDesign()).i_q_slew / derive(PAPER, DriveDesign()).i_q_slew
    assert slope == pytest.approx(1.5 / derive(PAPER, DriveDesign()).speed_hz)
    assert derive(own, DriveDesign(smo_pll_hz=33.0)).smo_cross_hz == 33.0


def test_the_page_has_the_numbers_of_the_paper_s_machine() -> None:
    values = asdict(derive(PAPER, DriveDesign()))
    rows = re.findall(r"^\| (`.*`) \|.*\| ([\d.]+)[^|]*\|$", PAGE.read_text("utf-8"), re.MULTILINE)
    found = {name: float(text) for names, text in rows for name in re.findall(r"`(\w+)`", names)}
    assert set(found) == set(values)
    for name, number in found.items():
        assert values[name] == pytest.approx(number, rel=0.006), name


def test_an_inverter_without_dead_time_has_gains() -> None:
    """A dead time of zero counts as the least that an inverter has."""
    none, least = (
        control_record(replace(PAPER, dead_time=time), DriveDesign())["coupled"]
        for time in (0.0, LEAST_DEAD_TIME * PAPER.T_s)
    )
    assert none["inv_layer"] == least["inv_layer"] and math.isfinite(none["inv_layer"])
    assert none["drift"]["k"] == least["drift"]["k"] > 0.0


@pytest.mark.parametrize("times", [1.0, 20.0])
def test_too_much_dead_time_compensated_is_a_fifth_of_the_emf_at_the_hand_over(
    times: float,
) -> None:
    """On an inverter that loses a quarter of what its file says; at most 0.75 is compensated."""
    motor = replace(PAPER, dead_time=times * PAPER.dead_time)
    u_dt = motor.u_dc * motor.dead_time / motor.T_s
    emf = 0.2 * motor.omega_rated * motor.psi_f
    share = derive(motor, DriveDesign()).dead_time_share
    assert share == pytest.approx(0.75 if times == 1.0 else 0.25 + 0.2 * emf / u_dt)
    assert (share - 0.25) * u_dt < 1.001 * 0.2 * emf


def test_a_light_shaft_gets_faster_signals() -> None:
    """Braked by i_max and a rated load the speed signal lags a quarter of rated at most."""
    brakes = 1.0 + PAPER.i_max / PAPER.i_rated
    for start, hz in ((100e-3, 30.0), (10e-3, 4.0 * brakes / (2.0 * math.pi * 10e-3))):
        motor = replace(PAPER, J=start * PAPER.n_p * PAPER.tau_rated / PAPER.omega_rated)
        assert derive(motor, DriveDesign()).signal_hz == pytest.approx(hz)
    assert all(derive(m, DriveDesign()).signal_hz == 30.0 for m in map(Motor.load, SHIPPED))


@pytest.mark.parametrize("motor", MACHINES, ids=lambda m: m.name)
def test_a_load_that_goes_leaves_the_speed_within_the_estimate_s_bound(motor: Motor) -> None:
    """At the largest reference: the rise is that of the IP loop, J dw/dt against its torque."""
    design = DriveDesign()
    record, w = control_record(motor, design), 2.0 * math.pi * derive(motor, design).speed_hz
    rise = motor.n_p * motor.tau_rated / (math.e * motor.J * w)
    most, bound = float(record["guard"]["omega"]), float(record["coupled"]["omega_max"])
    assert most + rise <= 1.0001 * bound or most == pytest.approx(0.5 * bound)
    assert most >= 0.499 * bound

"""Suites: any part of one is what it is in the whole."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.envs.scenarios.suites import SUITES, SuiteRows, suite
from sensorless.errors import UserError
from sensorless.machine.magnetics import flux, mtpa
from sensorless.machine.motor import MOTORS, Motor
from sensorless.units import RPM_TO_RAD_S

MOTOR = Motor.load("paper")


@pytest.mark.parametrize("name", SUITES)
def test_a_part_drawn_alone_is_that_part_of_the_whole(name: str) -> None:
    whole, rows = suite(name, MOTOR, 5, 121), SuiteRows(name, MOTOR, 5, 121)
    assert len(rows) == len(whole) == 121
    for part in (slice(0, 1), slice(17, 60), slice(60, 200)):
        drawn, wanted = rows[part].draw(), whole[part]
        assert len(rows[part]) == len(drawn)
        assert rows[part].seed.tolist() == drawn.seed.tolist()
        for f in fields(whole):
            a, b = getattr(drawn, f.name), getattr(wanted, f.name)
            assert a.dtype == b.dtype and a.tobytes() == np.ascontiguousarray(b).tobytes(), f.name


def test_a_part_of_a_part() -> None:
    rows = SuiteRows("handoff", MOTOR, 5, 121)
    assert rows[10:50][5:7] == SuiteRows("handoff", MOTOR, 5, 121, rows=range(15, 17))


@pytest.mark.parametrize(
    ("name", "seed", "size", "role", "said"),
    [
        ("nobody", 1, 9, "test", "suite"),
        ("stress", 1, 9, "play", "role"),
        ("stress", -1, 9, "test", "seed"),
        ("stress", 1, 0, "test", "size"),
        ("stress", 1, 4.0, "test", "size: 4.0"),
        ("envelope", 1, 10, "test", "square"),
    ],
)
def test_what_is_no_suite(name: str, seed: int, size: Any, role: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        SuiteRows(name, MOTOR, seed, size, role)


def test_help_names_every_suite() -> None:
    said = CliRunner().invoke(app, ["evaluate", "--help"], env={"COLUMNS": "200"}).stdout
    assert all(name in said for name in SUITES)
    document = (Path(__file__).parents[3] / "docs" / "suites.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in document for name in SUITES)


@pytest.mark.parametrize(
    "name", ["hold", "crawl", "impact", "stop", "unload", "braking", "sag", "reversal"]
)
@pytest.mark.parametrize("motor", ["paper", "ipmsm_2200w"])
def test_inertia_is_drawn_and_speeds_scale(name: str, motor: str) -> None:
    machine = Motor.load(motor)
    s, paper = suite(name, machine, 5, 440), suite(name, MOTOR, 5, 440)
    assert s.J.min() < 0.55 and s.J.max() > 2.7
    ratio = machine.n_rated_rpm / MOTOR.n_rated_rpm
    np.testing.assert_allclose(s.omega_0, ratio * paper.omega_0, rtol=1e-12)
    np.testing.assert_allclose(s.omega, ratio * paper.omega, rtol=1e-12)
    np.testing.assert_allclose(s.tau / machine.tau_rated, paper.tau / MOTOR.tau_rated, rtol=1e-12)


def test_hold_has_every_speed_with_both_signs_for_ten_seconds() -> None:
    s = suite("hold", MOTOR, 5, 10)
    cases = {(round(x / RPM_TO_RAD_S), tau) for x, tau in zip(s.omega_0, s.tau[:, -1], strict=True)}
    assert cases == {(rpm, tau) for rpm in (0, 5, -5, 20, -20) for tau in (14.0, -14.0)}
    np.testing.assert_allclose(s.duration - s.t[:, 1] - MOTOR.tau_rated / s.tau_rate[:, 1], 10.0)


def test_a_braking_load_drives_the_shaft_at_low_speed_until_the_end() -> None:
    s, wrong = suite("braking", MOTOR, 5, 200), suite("stress-1", MOTOR, 5, 200)
    speed = np.abs(s.omega_0) / RPM_TO_RAD_S
    assert 30.0 <= speed.min() < 60.0 and 420.0 < speed.max() <= 450.0
    assert (s.tau[:, -1] * s.omega_0 < 0.0).all(), "against the sign of a motor's load"
    assert (np.abs(s.tau[:, -1]) >= 0.5 * MOTOR.tau_rated).all()
    assert not s.tau[:, 0].any() and (s.omega == s.omega_0[:, None]).all()
    for name in ("R_s", "psi_f", "L_q_hat", "cross_hat", "dead_time", "gain", "offset"):
        np.testing.assert_array_equal(getattr(s, name), getattr(wrong, name))


def test_the_link_sags_under_load_and_comes_back() -> None:
    s = suite("sag", MOTOR, 5, 200)
    assert (s.u_dc[:, :2] == 1.0).all() and (s.u_dc[:, 3:] == 1.0).all()
    assert 0.7 <= s.u_dc[:, 2].min() < 0.72 and 0.93 < s.u_dc[:, 2].max() <= 0.95
    lasts = s.t[:, 3] - s.t[:, 2]
    assert 0.05 <= lasts.min() < 0.07 and 0.48 < lasts.max() <= 0.5
    assert (np.abs(s.omega_0) >= 0.5 * MOTOR.omega_m_rated).all()
    drives = (s.tau[:, -1] * s.omega_0 < 0.0).mean()
    assert 0.1 < drives < 0.3 and not s.tau[:, 0].any()


def test_impact_comes_and_goes_within_two_milliseconds_at_any_speed() -> None:
    s = suite("impact", MOTOR, 5, 44)
    cases = {(round(x / RPM_TO_RAD_S), tau) for x, tau in zip(s.omega_0, s.tau[:, 1], strict=True)}
    assert len(cases) == 42, "standstill has one direction"
    assert {abs(rpm) for rpm, _ in cases} == set(range(0, 1501, 150))
    np.testing.assert_allclose(np.abs(s.tau[:, 1]) / s.tau_rate[:, 1], 0.002)
    assert not s.tau[:, 2:].any()


def test_stops_end_at_rest_under_their_load_and_have_time() -> None:
    s = suite("stop", MOTOR, 5, 200)
    ends = s.t[:, 2] + np.abs(s.omega_0) / s.omega_rate[:, 2]
    np.testing.assert_allclose(s.duration - ends, 1.5)
    assert not s.omega[:, 2:].any() and (np.abs(s.tau[:, -1]) >= 0.25 * MOTOR.tau_rated).all()
    signs = {*zip(np.sign(s.omega_0), np.sign(s.tau[:, -1]), strict=True)}
    assert len(signs) == 4


def test_crawls_reverse_three_times() -> None:
    s = suite("crawl", MOTOR, 5, 200)
    top = np.abs(s.omega_0) / RPM_TO_RAD_S
    assert 15.0 <= top.min() < 17.0 and 58.0 < top.max() <= 60.0
    targets = np.sign(s.omega[:, :5] / s.omega_0[:, None])
    assert (targets == [1, 1, -1, 1, -1]).all()
    took = 2.0 * np.abs(s.omega_0) / s.omega_rate[:, 0]
    assert 0.4 <= took.min() and took.max() <= 1.2
    assert (s.t[:, 3] - s.t[:, 2] > took + 0.5).all()


def test_reversal_steps_through_zero_at_once_under_every_load() -> None:
    s = suite("reversal", MOTOR, 5, 400)
    before, after = s.omega_0, s.omega[:, 2]
    rated = MOTOR.omega_m_rated
    for speed in (before, after):
        assert 0.3 <= np.abs(speed / rated).min() < 0.32 and 0.98 < np.abs(speed / rated).max() <= 1
    assert (before * after < 0.0).all() and (s.omega_rate[:, 0] * MOTOR.T_s > rated).all()
    assert (s.tau[:, 1] == s.tau[:, 2]).all() and np.abs(s.tau).max() <= MOTOR.tau_rated
    signs = {(a, b) for a, b in zip(np.sign(before), np.sign(s.tau[:, 1]), strict=True)}
    assert signs == {(1, 1), (1, -1), (-1, 1), (-1, -1)}


def test_unload_draws_speeds_and_errors() -> None:
    s = suite("unload", MOTOR, 5, 400)
    rpm = np.abs(s.omega_0) / RPM_TO_RAD_S
    assert 40.0 <= rpm.min() < 43.0 and 247.0 < rpm.max() <= 250.0
    assert s.psi_f.min() < 0.95 and s.psi_f.max() > 1.05 and s.R_s.max() > 1.35
    assert s.dead_time.max() > 1.4 * MOTOR.dead_time and s.dead_time.min() < 0.35 * MOTOR.dead_time
    assert not s.tau[:, 2:].any() and (s.tau[:, 1] != 0.0).all()


def test_only_inverters_of_high_voltage_have_thresholds() -> None:
    """A MOSFET has a resistance; the row is otherwise that of the same machine on the mains."""
    hub = Motor.load("ebike_hub")
    low, high = (suite("stress", m, 3, 8) for m in (hub, replace(hub, u_dc=400.0)))
    for name in ("u_transistor", "u_diode"):
        assert not getattr(low, name).any() and (getattr(high, name) > 0.5).all()
    np.testing.assert_array_equal(low.p_iron, high.p_iron)
    np.testing.assert_array_equal(low.emf_5, high.emf_5)


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_the_iron_of_stress_loses_little_under_load(name: str) -> None:
    """With the flux linkage squared, at most 6 % of rated power at rated current."""
    motor = Motor.load(name)
    i = mtpa(motor)
    rated = [np.interp(motor.i_rated, np.hypot(*i.T), x) for x in flux(motor.saturation, i).T]
    grows = (np.hypot(*rated) / motor.psi_f) ** 2
    most = float(np.max(suite("stress", motor, 3, 512).p_iron))
    share = most / (motor.tau_rated * motor.omega_m_rated)
    bound = min(0.03, 0.06 / grows)
    assert 0.98 * bound < share <= 1.01 * bound


def test_other_machines_than_the_drive_was_designed_for() -> None:
    """``mismatch`` and ``low-inertia`` change what they name; the profile is that of stress-1."""
    usual, wrong, light = (
        suite(name, MOTOR, 5, 400) for name in ("stress-1", "mismatch", "low-inertia")
    )
    for s, left in ((wrong, "J"), (light, "R_s")):
        assert np.array_equal(s.omega, usual.omega) and np.array_equal(s.t, usual.t)
        assert np.array_equal(getattr(s, left), getattr(usual, left))
    for name, low, high in (
        ("R_s", 0.7, 2.0), ("psi_f", 0.85, 1.06), ("L_q_hat", 0.6, 1.35), ("cross_hat", 0.0, 1.8)
    ):  # fmt: skip
        x = getattr(wrong, name)
        assert low <= x.min() < low + 0.05 * (high - low)
        assert high >= x.max() > high - 0.05 * (high - low)
    assert 0.15 <= light.J.min() < 0.16 and 0.48 < light.J.max() <= 0.5
    ratio = light.omega_rate * light.J[:, None] / (usual.omega_rate * usual.J[:, None])
    assert np.allclose(ratio, 1.0)

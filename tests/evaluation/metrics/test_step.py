"""Overshoot, settling and dip against closed forms, on made-up speeds under a real profile."""

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIM, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.evaluation.metrics.profile import reference
from sensorless.evaluation.metrics.step import (
    dip_excess_pct_s,
    dip_pct_s,
    overshoot_clean_above,
    overshoot_clean_pct,
    overshoot_excess_pct,
    overshoot_pct,
    settling_s,
    settling_twin_s,
)
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
Floats = NDArray[np.float64]

TIME = (np.arange(2000) + 0.5) * 1e-3
"""Middle of each decision [s]."""
NONE = np.zeros(2000)


def profile(*segments: tuple[float, float, float]) -> Scenarios:
    """One scenario of 2 s: (start [s], speed target [rad/s], load [N m]) for each segment."""
    s = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), 2.0)
    for j, (t, omega, tau) in enumerate(segments):
        s.t[0, j] = t
        s.omega[0, j:] = omega
        s.tau[0, j:] = tau
    return s


def made_up(
    scenario: Scenarios, omega: Floats, twin: Floats | None = None, live: int = 10_000
) -> Rollout:
    """A drive with these speeds [rad/s] at ``TIME`` that lives for ``live`` periods."""
    sums = np.zeros((len(omega), 1), dtype=SIM["sums"])
    periods = np.clip(live - 5 * np.arange(len(omega)), 0, 5)
    sums["n"][:, 0] = periods
    sums["omega_m"][:, 0] = periods * omega
    sums["omega_m_twin"][:, 0] = periods * (omega if twin is None else twin)
    return Rollout(MOTOR, scenario, sums, np.zeros(1, dtype=np.int32), np.array([live]))


def rise(start: float, stop: float, bump: float, at: float = 0.0) -> Floats:
    """Speed that steps at ``at`` and goes beyond ``stop`` by ``bump`` once."""
    hump = bump * np.exp(-(((TIME - at - 0.3) / 0.05) ** 2))
    return np.where(TIME < at, start, stop - (stop - start) * np.exp(-(TIME - at) / 0.05) + hump)


@pytest.mark.parametrize(
    ("start", "stop", "bump", "expected"),
    [
        (0.0, 100.0, 5.0, 5.0),
        (100.0, 60.0, -6.0, 15.0),
        (80.0, -80.0, -8.0, 5.0),
        (0.0, 100.0, -9.0, 0.0),
    ],
)
def test_overshoot_is_beyond_the_target_in_the_direction_of_the_step(
    start: float, stop: float, bump: float, expected: float
) -> None:
    scenario = profile((0.0, start, 0.0), (0.5, stop, 0.0))
    scenario.omega_0[:] = start
    r = made_up(scenario, rise(start, stop, bump, 0.5))
    assert overshoot_pct(r)[0] == pytest.approx(expected, abs=0.3)
    assert overshoot_excess_pct(r)[0] == 0.0


@pytest.mark.parametrize(("share", "expected"), [(0.049, np.nan), (0.051, 20.0)])
def test_a_step_is_at_least_a_twentieth_of_rated(share: float, expected: float) -> None:
    """Of rated speed for the overshoot, here 20 % of the height; of rated torque for the dip."""
    height = share * RATED
    r = made_up(
        profile((0.0, 0.0, 0.0), (0.5, height, 0.0)), np.where(TIME > 0.5, 1.2 * height, 0.0)
    )
    assert overshoot_pct(r)[0] == pytest.approx(expected, abs=1e-3, nan_ok=True)
    load = profile((0.0, 0.0, 0.0), (0.5, 0.0, share * MOTOR.tau_rated))
    assert np.isnan(dip_pct_s(made_up(load, NONE))[0]) == np.isnan(expected)


def test_overshoot_against_the_twin_is_taken_step_by_step() -> None:
    scenario = profile((0.0, 100.0, 0.0), (1.0, 50.0, 0.0))
    drive = np.where(TIME < 1.0, rise(0.0, 100.0, 10.0), rise(100.0, 50.0, -4.0, 1.0))
    twin = np.where(TIME < 1.0, rise(0.0, 100.0, 10.0), rise(100.0, 50.0, -1.0, 1.0))
    r = made_up(scenario, drive, twin)
    assert overshoot_pct(r)[0] == pytest.approx(10.0, abs=0.3)
    assert overshoot_excess_pct(r)[0] == pytest.approx(6.0, abs=0.3)


@pytest.mark.parametrize(
    ("first", "second", "twin", "expected", "above"),
    [
        (10.0, -1.5, 10.0, 3.0, 1.0),
        (10.0, -0.9, 10.0, 1.8, 0.0),
        (10.0, -1.15, 10.0, 2.3, 1.0),
        (4.0, -0.5, 0.2, 4.0, 1.0),
        (4.0, -0.5, 0.8, 1.0, 0.0),
    ],
)
def test_overshoot_where_the_twin_has_none(
    first: float, second: float, twin: float, expected: float, above: float
) -> None:
    scenario = profile((0.0, 100.0, 0.0), (1.0, 50.0, 0.0))
    drive = np.where(TIME < 1.0, rise(0.0, 100.0, first), rise(100.0, 50.0, second, 1.0))
    other = np.where(TIME < 1.0, rise(0.0, 100.0, twin), rise(100.0, 50.0, 0.0, 1.0))
    r = made_up(scenario, drive, other)
    assert overshoot_clean_pct(r)[0] == pytest.approx(expected, abs=0.3)
    assert overshoot_clean_above(r)[0] == above


def test_no_step_without_overshoot_of_the_twin_no_value() -> None:
    speed = rise(0.0, 100.0, 10.0)
    r = made_up(profile((0.0, 100.0, 0.0)), speed, speed)
    assert np.isnan(overshoot_clean_pct(r)[0])
    assert np.isnan(overshoot_clean_above(r)[0])


def test_speed_after_the_next_step_is_no_overshoot() -> None:
    scenario = profile((0.0, 50.0, 0.0), (1.0, 120.0, 0.0))
    speed = np.where(TIME < 1.0, rise(0.0, 50.0, 0.0), rise(50.0, 120.0, 0.0, 1.0))
    assert overshoot_pct(made_up(scenario, speed))[0] == pytest.approx(0.0, abs=1e-4)


def test_a_window_ends_at_the_next_speed_step_whatever_comes_between() -> None:
    scenario = profile((0.0, 50.0, 0.0), (0.5, 50.0, 5.0), (1.0, 120.0, 5.0))
    speed = np.where(TIME < 1.0, rise(0.0, 50.0, 0.0), rise(50.0, 120.0, 0.0, 1.0))
    assert overshoot_pct(made_up(scenario, speed))[0] == pytest.approx(0.0, abs=1e-4)


def test_a_change_of_load_does_not_end_the_window() -> None:
    scenario = profile((0.0, 100.0, 0.0), (1.0, 100.0, -10.0))
    speed = np.where((TIME > 1.2) & (TIME < 1.3), 107.0, 100.0)
    assert overshoot_pct(made_up(scenario, speed))[0] == pytest.approx(7.0, abs=1e-4)


def test_a_decision_in_which_a_step_falls_is_no_part_of_its_window() -> None:
    """From 0.5003 s on: the speed of 0.5 to 0.501 s is that before it, too."""
    scenario = profile((0.0, 0.0, 0.0), (0.5003, 100.0, 0.0))
    speed = np.where(TIME < 0.501, 0.0, 100.0)
    speed[500] = 130.0
    assert overshoot_pct(made_up(scenario, speed))[0] == 0.0
    speed[501] = 110.0
    assert overshoot_pct(made_up(scenario, speed))[0] == pytest.approx(10.0)


def test_a_step_is_as_high_as_the_reference_had_to_go() -> None:
    scenario = profile((0.0, 100.0, 0.0), (0.5, 150.0, 0.0))
    scenario.omega_rate[:] = 40.0
    r = made_up(scenario, np.where(TIME < 0.5, 20.0, 163.0))
    assert overshoot_pct(r)[0] == pytest.approx(10.0, rel=1e-4)


def test_steps_below_5_percent_are_passed_over() -> None:
    scenario = profile((0.0, 0.04 * RATED, 0.0))
    r = made_up(scenario, np.full(2000, 0.1 * RATED))
    assert np.isnan(overshoot_pct(r)[0])
    assert np.isnan(settling_s(r)[0])
    assert np.isnan(dip_pct_s(r)[0])
    r = made_up(profile((0.0, 0.052 * RATED, 0.0)), np.full(2000, 0.078 * RATED))
    assert overshoot_pct(r)[0] == pytest.approx(50.0)
    for share, seen in ((0.048, False), (0.052, True)):
        load = profile((0.0, 0.0, 0.0), (0.5, 0.0, share * MOTOR.tau_rated))
        assert np.isfinite(dip_pct_s(made_up(load, np.zeros(2000)))[0]) == seen


def test_settling_of_a_first_order_lag_is_ln_50_time_constants() -> None:
    scenario = profile((0.0, 0.0, 0.0), (0.3, 100.0, 0.0))
    speed = np.where(TIME < 0.3, 0.0, 100.0 * (1.0 - np.exp(-(TIME - 0.3) / 0.1)))
    assert settling_s(made_up(scenario, speed))[0] == pytest.approx(0.1 * np.log(50.0), abs=1.5e-3)


def test_settling_counts_from_the_last_time_outside_of_the_band() -> None:
    scenario = profile((0.0, 100.0, 0.0))
    speed = np.full(2000, 100.0)
    speed[700:750] = 102.5
    twin = np.where(TIME < 0.2, 0.0, 100.0)
    r = made_up(scenario, speed, twin)
    assert settling_s(r)[0] == pytest.approx(0.75)
    assert settling_twin_s(r)[0] == pytest.approx(0.2)


def test_the_band_of_settling_is_over_the_height_of_the_step() -> None:
    """2 % of 50 rad/s is 1 rad/s, whatever the target."""
    scenario = profile((0.0, 100.0, 0.0), (0.5, 150.0, 0.0))
    scenario.omega_0[:] = 100.0
    speed = np.select([TIME < 0.5, TIME < 0.9, TIME < 1.2], [100.0, 151.1, 150.9], 150.0)
    assert settling_s(made_up(scenario, speed))[0] == pytest.approx(0.4)


def test_a_step_that_does_not_settle_has_no_settling_time() -> None:
    scenario = profile((0.0, 100.0, 0.0), (1.0, 50.0, 0.0))
    speed = np.where(TIME < 1.0, 90.0, 50.0)
    assert np.isnan(settling_s(made_up(scenario, speed))[0])


def test_dip_is_the_area_below_the_reference_after_a_load_step() -> None:
    scenario = profile((0.0, 0.5 * RATED, 0.0), (0.5, 0.5 * RATED, 7.0))
    scenario.omega_0[:] = 0.5 * RATED
    speed = np.full(2000, 0.5 * RATED)
    speed[100:200] -= 0.3 * RATED
    speed[600:800] -= 0.1 * RATED
    speed[900:950] += 0.2 * RATED
    r = made_up(scenario, speed, np.full(2000, 0.5 * RATED))
    assert dip_pct_s(r)[0] == pytest.approx(100.0 * 0.1 * 0.2, rel=1e-4)
    assert dip_excess_pct_s(r)[0] == pytest.approx(2.0, rel=1e-4)
    twin = np.where((TIME > 0.6) & (TIME < 0.75), 0.4, 0.5) * RATED
    assert dip_excess_pct_s(made_up(scenario, speed, twin))[0] == pytest.approx(0.5, rel=1e-3)


def test_the_lag_behind_a_later_speed_step_is_no_dip() -> None:
    scenario = profile((0.0, 50.0, 0.0), (0.5, 50.0, 7.0), (1.0, 120.0, 7.0))
    scenario.omega_0[:] = 50.0
    speed = np.where((TIME > 0.6) & (TIME < 0.7), 50.0 - 0.1 * RATED, 50.0)
    assert dip_pct_s(made_up(scenario, speed))[0] == pytest.approx(1.0, rel=1e-3)


def test_a_load_that_lets_go_speeds_up() -> None:
    scenario = profile((0.0, 50.0, 7.0), (1.0, 50.0, 0.0))
    scenario.omega_0[:] = 50.0
    speed = np.where((TIME > 1.0) & (TIME < 1.1), 50.0 + 0.1 * RATED, 50.0)
    assert dip_pct_s(made_up(scenario, speed))[0] == pytest.approx(1.0, rel=1e-3)


def test_the_end_of_a_drive_ends_its_windows() -> None:
    scenario = profile((0.0, 100.0, 0.0), (1.5, 20.0, 0.0))
    speed = np.where(TIME < 1.0, 103.0, 500.0)
    r = made_up(scenario, speed, live=5003)
    assert overshoot_pct(r)[0] == pytest.approx(3.0, abs=1e-4)


def test_the_reference_is_that_of_the_core() -> None:
    scenarios = stress_1_scenarios(MOTOR, np.arange(20, dtype=np.uint64))
    factory = SimFactory(MOTOR, DriveDesign())
    ours = reference(rollout(make_policy("sensored", MOTOR), scenarios, factory))
    sims = factory.build(scenarios, sensored=True, twin=False)
    obs = np.zeros((20, 12), dtype=np.float32)
    for j in range(2000):
        sim_run(sims, 3, np.ones(20, dtype=np.float32), obs)
        core = sims["now"]["omega_ref"] / MOTOR.n_p
        sim_run(sims, 2, np.ones(20, dtype=np.float32), obs)
        np.testing.assert_allclose(ours[j], core, atol=0.002 * RATED, err_msg=f"decision {j}")

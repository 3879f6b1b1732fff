"""Starts from an unknown angle, as many drives at once: pole, direction, spinning shafts."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import Floats, combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.evaluation.metrics.start import backward_excess_pct, start_err_deg, start_s
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.start_design import alike, knows_poles, peaks, polarity_pulse, spin_speed
from sensorless.policies.registry import make_policy
from sensorless.units import RPM_TO_RAD_S
from tests.helpers.drives import Alone
from tests.helpers.scenarios import lasting

MOTOR = Motor.load("paper")
N = 504
DONE, FLY, SETTLE = lib.START_DONE, lib.START_FLY, lib.START_SETTLE


@cache
def starts(n: int = N, polarity: bool = True) -> Rollout:
    """The suite under Eq. 25; without polarity detection the first guess of the pole is kept.

    That is for the start alone, 0.1 s.
    """
    if polarity:
        factory = SimFactory(MOTOR, DriveDesign())
        return rollout(make_policy("eq25", MOTOR), suite("starts", MOTOR, 1, n), factory)
    factory = Alone(MOTOR, DriveDesign())
    factory.template["control"]["start"]["i_pole"] = 0.0
    return rollout(make_policy("eq25", MOTOR), lasting(0.1)("starts", MOTOR, 1, n), factory)


def kind(n: int) -> Array:
    """0 no load, 1 active load, 2 passive load, 3 spinning shaft."""
    return np.arange(n) // 2 % 4


def to_release(scenarios: Scenarios, design: DriveDesign | None = None) -> tuple[Array, Floats]:
    """Drives after 50 ms, and the largest angle error of the 10 ms after that [deg]."""
    sims = SimFactory(MOTOR, design or DriveDesign()).build(scenarios)
    n = len(sims)
    k_s, obs = np.ones(n, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    k_s[np.abs(scenarios.omega_0) > 350.0 * RPM_TO_RAD_S] = 0.0
    sim_run(sims, round(0.05 / MOTOR.T_s), k_s, obs)
    released = sims.copy()
    sim_run(sims, round(0.01 / MOTOR.T_s), k_s, obs)
    return released, np.rad2deg(sims["sums"]["err_max"])


def test_the_suite_is_what_it_says() -> None:
    """Any angle; half of the first estimates beyond 90 degrees; loads, speeds over their range."""
    s = suite("starts", MOTOR, 1, 1000)
    assert s.seek.all()
    assert np.histogram(s.theta_0, 8, (-np.pi, np.pi))[0].min() > 90
    wrapped = np.abs(np.angle(np.exp(1j * s.theta_err_0)))
    assert (wrapped > 0.5 * np.pi).sum() == 500
    half = 0.5 * MOTOR.tau_rated
    assert s.tau[kind(1000) == 1].min() < -0.9 * half and s.tau.max() > 0.9 * half
    assert (s.tau[kind(1000) == 0] == 0.0).all() and s.passive.sum() == 250
    assert (
        np.abs(s.omega_0).max() > 0.95 * 1500.0 * RPM_TO_RAD_S and (s.omega_0 != 0.0).sum() == 250
    )


def test_five_hundred_starts() -> None:
    """None with the wrong pole, none lost, none further backwards than its load drives the twin."""
    r = starts()
    assert (r.lost == 0).all()
    assert np.nanmax(start_err_deg(r)) < 15.0 and not np.isnan(start_err_deg(r)).any()
    assert start_s(r).max() < 0.06
    excess = backward_excess_pct(r)
    assert np.isnan(excess).sum() == N // 4
    free = np.isin(kind(N), (0, 2))
    assert np.nanmax(excess[free]) < 2.5
    assert np.nanmax(excess) < 5.0


def test_drives_reach_their_targets() -> None:
    """From rest within the 0.9 s after the target is set."""
    r = starts()
    end = r.sums["omega_m"][-1] / r.sums["n"][-1]
    away = np.abs(end - r.scenarios.omega[:, 1])[kind(N) != 3]
    assert away.max() < 0.05 * 1500.0 * RPM_TO_RAD_S


def test_without_polarity_detection_half_of_them_fail() -> None:
    """At rest, exactly the drives whose first estimate is half a turn off start the wrong way.

    But for those whose first error is within 5 degrees of 90, or whose load turns the shaft there.
    """
    r = starts(400, polarity=False)
    err = np.abs(np.angle(np.exp(1j * r.scenarios.theta_err_0)))
    rest = kind(400) != 3
    still = (kind(400) == 0) | (kind(400) == 2)
    clear = np.abs(err - 0.5 * np.pi) > np.deg2rad(5.0)
    wrong = start_err_deg(r) > 90.0
    assert np.array_equal(wrong[still & clear], (err > 0.5 * np.pi)[still & clear])
    assert 0.45 < wrong[rest].mean() < 0.55
    spins = np.abs(r.scenarios.omega_0) > 500.0 * RPM_TO_RAD_S
    assert spins.sum() > 50 and not wrong[spins].any()


def standing(err: Floats, theta: Floats, tau: float = 0.0, noise: float = 0.005) -> Scenarios:
    s = Scenarios.nominal(MOTOR, combine(3, np.arange(len(err))), 1.0)
    s.seek[:], s.theta_err_0, s.theta_0 = True, err, theta
    s.tau[:], s.noise[:] = tau, noise
    return s


@pytest.mark.parametrize("tau", [-7.0, 0.0, 7.0])
@pytest.mark.parametrize("noise", [0.0, 0.012])
def test_every_first_error(tau: float, noise: float) -> None:
    """Over a grid of errors and angles, the unstable 90 and the wrong 180 degrees among them."""
    err, theta = (
        x.ravel() for x in np.meshgrid(np.pi * np.arange(-12, 13) / 12, np.arange(-3.0, 3.1, 1.0))
    )
    released, after = to_release(standing(err, theta, tau, noise))
    assert (released["drive"]["x"]["start"]["phase"] == DONE).all()
    assert (released["drive"]["x"]["fault"] == 0).all()
    assert after.max() < 12.0


def test_the_shaft_is_not_moved() -> None:
    """Without load the shaft stays below 3 r/min and within half an electrical degree."""
    theta = np.linspace(-3.0, 3.0, 40)
    sims = SimFactory(MOTOR, DriveDesign()).build(standing(np.full(40, 2.0), theta))
    k_s, obs = np.ones(40, np.float32), np.zeros((40, SIGNAL_N), np.float32)
    fastest = np.zeros(40)
    while (sims["drive"]["x"]["start"]["phase"] != DONE).any():
        sim_run(sims, 1, k_s, obs)
        fastest = np.maximum(fastest, np.abs(sims["drive"]["y"]["omega_m"]))
    assert fastest.max() < 3.0 * RPM_TO_RAD_S
    assert np.abs(sims["drive"]["y"]["theta_e"] - theta).max() < np.deg2rad(0.5)


def flying(rpm: Floats) -> Scenarios:
    s = standing(np.zeros(len(rpm)), np.linspace(-3.1, 3.1, len(rpm)), noise=0.012)
    s.omega_0 = rpm * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    return s


def test_flying_starts() -> None:
    """From -1500 to 1500 r/min: speed and its sign are found, the shaft hardly slowed."""
    rpm = np.linspace(-1500.0, 1500.0, 301)
    released, after = to_release(flying(rpm))
    x, y = released["drive"]["x"], released["drive"]["y"]
    assert (x["start"]["phase"] == DONE).all() and (x["fault"] == 0).all()
    assert after.max() < 15.0
    found = x["est"]["omega"] / MOTOR.n_p / RPM_TO_RAD_S
    true = y["omega_m"] / RPM_TO_RAD_S
    assert np.abs(found - true).max() < 60.0
    assert np.abs(true - rpm).max() < 75.0


def test_fast_shafts_are_caught_by_the_emf_and_slow_ones_by_injection() -> None:
    rpm = np.array([-1500.0, -500.0, -420.0, -300.0, -100.0, 100.0, 300.0, 420.0, 500.0, 1500.0])
    sims = SimFactory(MOTOR, DriveDesign()).build(flying(rpm))
    k_s, obs = np.ones(10, np.float32), np.zeros((10, SIGNAL_N), np.float32)
    sim_run(sims, round(0.015 / MOTOR.T_s), k_s, obs)
    phase = sims["drive"]["x"]["start"]["phase"]
    assert np.array_equal(phase == FLY, np.abs(rpm) > 400.0)


def test_the_pulse_follows_from_the_flux_map() -> None:
    """Paper's machine by hand: i_d = (13 + 0.59097761 psi^4) psi - 13.479581 around 0.993 Vs."""
    volt_seconds, difference = polarity_pulse(MOTOR)
    by_hand = []
    for psi in (0.993 + volt_seconds, 0.993 - volt_seconds):
        by_hand.append((13.0 + 0.59097761 * psi**4) * psi - 13.479581)
    assert peaks(MOTOR, volt_seconds) == pytest.approx(by_hand, abs=1e-6)
    assert difference == pytest.approx(sum(by_hand), abs=1e-6)
    assert 0.08 * MOTOR.i_rated <= difference < 0.09 * MOTOR.i_rated
    assert max(np.abs(by_hand)) <= MOTOR.i_max


def test_measured_difference_is_that_of_the_map() -> None:
    """At rest within 15 % of the design value; negative for the wrong pole."""
    released, _ = to_release(standing(np.array([0.1, 3.0]), np.array([0.4, 0.4])))
    found = released["drive"]["x"]["start"]["i_pole"]
    assert found == pytest.approx(polarity_pulse(MOTOR)[1] * np.array([1.0, -1.0]), rel=0.15)


def test_a_bridge_turns_the_sign() -> None:
    """The PM-SyRM saturates for current against the magnet; its poles are told apart as well."""
    motor = Motor.load("pmsyrm_5600w")
    assert polarity_pulse(motor)[1] < 0.0
    factory = Alone(motor, DriveDesign())
    r = rollout(make_policy("eq25", motor), lasting(0.1)("starts", motor, 1, 64), factory)
    assert np.nanmax(start_err_deg(r)) < 30.0 and not np.isnan(start_err_deg(r)).any()


def test_an_unsure_pole_is_a_fault() -> None:
    """A machine whose saturation is a tenth of what was designed for: three tries, then the bit."""
    sims = SimFactory(MOTOR, DriveDesign()).build(standing(np.zeros(1), np.zeros(1), noise=0.0))
    sims["control"]["start"]["i_pole_sure"] = 10.0
    k_s, obs = np.ones(1, np.float32), np.zeros((1, SIGNAL_N), np.float32)
    sim_run(sims, round(0.06 / MOTOR.T_s), k_s, obs)
    x = sims["drive"]["x"]
    assert (x["start"]["phase"][0], x["start"]["tries"][0]) == (DONE, 3)
    assert x["fault"][0] == lib.FAULT_POLE


def test_poles_that_pulses_hardly_tell_apart_are_not_sought() -> None:
    """The paper's machine with 0.075 of its saturation along d, and L_d and psi_f as they are."""
    iron = replace(MOTOR.saturation, a_d0=15.65754, a_dd=0.0443233, i_f=15.59073)
    weak = replace(MOTOR, saturation=iron)
    assert knows_poles(MOTOR) and not knows_poles(weak)
    assert "differ by 3.0% of rated current, 4% are needed" in alike(weak)


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_the_emf_of_a_spinning_shaft_shows_the_pole_of_every_machine(name: str) -> None:
    """From ``spin_speed`` on, from any angle and in both directions; no pulse is needed."""
    motor, angles = Motor.load(name), np.tile(np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False), 6)
    s = Scenarios.nominal(motor, combine(1, np.arange(len(angles))), 1.0)
    s.seek[:], s.theta_0 = True, angles
    s.theta_err_0[:] = angles[::-1]
    speed = np.repeat([-3.0, -1.5, -1.0, 1.0, 1.5, 3.0], 32) * spin_speed(motor)
    s.omega_0 = speed * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, DriveDesign()).build(s)
    k_s, obs = np.ones(len(s), np.float32), np.zeros((len(s), SIGNAL_N), np.float32)
    sim_run(sims, round(0.05 / motor.T_s), k_s, obs)
    x, theta = sims["drive"]["x"], sims["drive"]["y"]["theta_e"]
    assert (x["start"]["phase"] == DONE).all() and (x["fault"] == 0).all()
    assert np.abs(np.angle(np.exp(1j * (theta - x["est"]["theta"])))).max() < np.deg2rad(30.0)


def test_machines_without_saturation_are_refused() -> None:
    motor = Motor.load("ipmsm_2200w")
    with pytest.raises(UserError, match=r"start: the poles of ipmsm_2200w look alike: .* by 0.0%"):
        SimFactory(motor, DriveDesign()).build(suite("starts", motor, 1, 2))


def test_twin_waits_and_lock_counts_from_the_release_on() -> None:
    """Until control begins the twin gives no torque and an error of 180 degrees loses nothing."""
    s = standing(np.array([np.pi]), np.array([0.3]), tau=5.0)
    sims = SimFactory(MOTOR, DriveDesign()).build(s)
    k_s, obs = np.ones(1, np.float32), np.zeros((1, SIGNAL_N), np.float32)
    sim_run(sims, round(0.03 / MOTOR.T_s), k_s, obs)
    assert sims["drive"]["x"]["start"]["phase"][0] == SETTLE
    sums = sims["sums"][0]
    assert sums["starting"] == sums["n"] and sums["err_max"] == 0.0 and sims["err_count"][0] == 0
    assert abs(sums["tau_twin"]) / sums["n"] < 0.05
    load = 5.0 / MOTOR.J * 0.03
    assert sims["twin"]["y"]["omega_m"][0] == pytest.approx(-load, rel=0.02)
    sim_run(sims, round(0.1 / MOTOR.T_s), k_s, obs)
    assert sims["twin"]["y"]["tau"][0] > 4.0 and sims["drive"]["y"]["tau"][0] > 4.0


def test_a_passive_load_only_resists() -> None:
    """At rest it does nothing; it brakes a spinning shaft to rest and not beyond."""
    s = standing(np.zeros(2), np.zeros(2), tau=5.0)
    s.seek[:], s.passive[:] = False, True
    s.omega_0 = np.array([0.0, 100.0 * RPM_TO_RAD_S])
    sims = SimFactory(MOTOR, DriveDesign()).build(s, sensored=True)
    sims["control"]["control"]["i_max"] = 0.0
    k_s, obs = np.ones(2, np.float32), np.zeros((2, SIGNAL_N), np.float32)
    lowest = np.zeros(2)
    for _ in range(100):
        sim_run(sims, 5, k_s, obs)
        lowest = np.minimum(lowest, sims["drive"]["y"]["omega_m"])
    assert lowest.min() > -1e-3
    assert np.abs(sims["drive"]["y"]["omega_m"]).max() < 3.0 * RPM_TO_RAD_S


@pytest.mark.parametrize("name", ["error_blend", "flux_observer"])
def test_starts_on_the_other_estimators(name: str) -> None:
    """They take over from the start sequence like the default, spinning shafts included."""
    r = rollout(
        make_policy(name, MOTOR), suite("starts", MOTOR, 2, 64), SimFactory(MOTOR, DriveDesign())
    )
    assert (r.lost == 0).all()
    assert np.nanmax(start_err_deg(r)) < 15.0

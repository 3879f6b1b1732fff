"""Not held: closed forms on made-up speeds, the known bad case, and what must not fire."""

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.metrics.held import away_s, not_held, swing_pct, twin_swing_pct
from sensorless.evaluation.metrics.profile import reference, since_change
from sensorless.evaluation.rollout import Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
SMO = DriveDesign(estimator="smo")
TIME = (np.arange(3000) + 0.5) * 1e-3
"""Middle of each decision [s]."""
NONE = np.zeros(3000)
Floats = NDArray[np.float64]


def load_at(t: float, rise: float = 0.0) -> Scenarios:
    """Standstill for 3 s with a rated load from ``t`` on, risen within ``rise`` [s]."""
    s = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), 3.0)
    s.t[0, 1], s.tau[0, 1:] = t, MOTOR.tau_rated
    s.tau_rate[:] = MOTOR.tau_rated / rise if rise else np.inf
    return s


def made_up(scenario: Scenarios, share: Floats, twin: Floats = NONE, live: int = 15_000) -> Rollout:
    """A drive with these speeds over rated at ``TIME`` that lives for ``live`` periods."""
    sums = np.zeros((len(share), 1), dtype=SIM["sums"])
    periods = np.clip(live - 5 * np.arange(len(share)), 0, 5)
    sums["n"][:, 0] = periods
    sums["omega_m"][:, 0] = periods * share * RATED
    sums["omega_m_twin"][:, 0] = periods * twin * RATED
    return Rollout(MOTOR, scenario, sums, np.zeros(1, dtype=np.int32), np.array([live]))


def wave(percent: float, hz: float) -> Floats:
    """Peak to peak of rated speed."""
    return np.asarray(0.005 * percent * np.sin(2.0 * np.pi * hz * TIME))


@pytest.mark.parametrize("hz", [5.0, 12.7, 40.0])
def test_a_limit_cycle_shows_its_peak_to_peak(hz: float) -> None:
    for percent, loose in ((1.8, 0.0), (2.2, 1.0)):
        r = made_up(load_at(0.5), wave(percent, hz))
        assert swing_pct(r)[0] == pytest.approx(percent, rel=0.03)
        assert not_held(r)[0] == loose
        assert away_s(r)[0] == 0.0, "it stays within the band all the while"


def test_a_drive_at_its_reference_is_not_away_from_a_twin_that_swings() -> None:
    r = made_up(load_at(0.5), NONE, wave(6.0, 5.0))
    assert away_s(r)[0] == 0.0 and not_held(r)[0] == 0.0
    assert twin_swing_pct(r)[0] > 2.0


def test_a_drive_near_its_reference_is_not_away_from_a_twin_on_the_other_side() -> None:
    """3 % apart, and either within 2 % of the reference."""
    r = made_up(load_at(0.5), np.full(3000, 0.015), np.full(3000, -0.015))
    assert away_s(r)[0] == 0.0


@pytest.mark.parametrize(
    ("gap", "arrives", "away"), [(0.099, 2.5, 0), (0.05, 1.5, 1), (0.101, 2.5, 1)]
)
def test_beside_a_twin_on_its_way_only_a_wide_gap_counts(
    gap: float, arrives: float, away: bool
) -> None:
    """Both slow down from half of rated speed since 0.5 s; the drive is ``gap`` faster.

    A tenth of rated speed is wide.
    """
    twin = 0.5 * np.clip((arrives - TIME) / (arrives - 0.5), 0.0, 1.0)
    r = made_up(load_at(0.5), np.where(TIME > 0.5, twin + gap, twin) * (TIME < 2.4), twin)
    assert not_held(r)[0] == away


def test_what_the_twin_swings_too_is_no_fault() -> None:
    twin = wave(5.0, 10.0)
    assert swing_pct(made_up(load_at(0.5), twin, twin))[0] == pytest.approx(0.0, abs=1e-5)
    assert twin_swing_pct(made_up(load_at(0.5), twin, twin))[0] == pytest.approx(5.0, rel=0.03)
    assert swing_pct(made_up(load_at(0.5), 1.5 * twin, twin))[0] == pytest.approx(2.5, rel=0.03)


def test_a_twin_that_swings_slowly_is_told_from_four_turns_in_600_ms() -> None:
    """Three half cycles of 3 Hz take 0.5 s, so the blocks of 0.1 s with their ends span six."""
    twin = wave(5.0, 3.0)
    assert twin_swing_pct(made_up(load_at(0.5), twin, twin))[0] == pytest.approx(5.0, rel=0.1)


def test_one_way_there_and_back_is_no_swing_of_the_twin_and_once_more_is() -> None:
    """Within 0.6 s: 5 % up and down; up, down and up; down, up and down."""
    since = np.clip(TIME - 1.0, 0.0, 9.0)
    up = 0.025 * (1.0 - np.cos(2.0 * np.pi * 2.5 * np.minimum(since, 0.6)))
    once = 0.025 * (1.0 - np.cos(2.0 * np.pi * np.minimum(since, 0.6) / 0.6))
    for twin, wanted in ((once, 0.0), (up, 5.0), (-up, 5.0)):
        found = twin_swing_pct(made_up(load_at(0.5), twin, twin))[0]
        assert found == pytest.approx(wanted, abs=0.15)


def test_a_swing_that_dies_counts_as_what_is_left_of_it() -> None:
    """Of exp(-t / 0.2 s) the third window, whose first peak is 0.4 s after the first one's."""
    decay = np.exp(-np.maximum(TIME - 0.5, 0.0) / 0.2)
    r = made_up(load_at(0.5), wave(20.0, 20.0) * decay)
    begin = 0.8 + 0.4
    at = (TIME > begin) & (TIME < begin + 0.2)
    assert swing_pct(r)[0] == pytest.approx(
        100.0 * np.ptp((wave(20.0, 20.0) * decay)[at]), rel=0.05
    )
    assert not_held(r)[0] == 0.0


def test_too_short_a_rest_shows_no_swing() -> None:
    s = load_at(0.8)
    s.t[0, 2], s.u_dc[0, 2:] = 1.6, 0.9
    s.t[0, 3], s.u_dc[0, 3:] = 2.2, 1.0
    assert np.isnan(swing_pct(made_up(s, wave(5.0, 10.0)))[0])
    assert swing_pct(made_up(load_at(2.0), wave(5.0, 10.0) * (TIME > 2.0)))[0] > 4.0


@pytest.mark.parametrize(("back", "loose"), [(0.45, 0.0), (0.55, 1.0), (9.0, 1.0)])
def test_the_time_until_the_speed_is_back(back: float, loose: float) -> None:
    off = np.where((TIME > 0.5) & (TIME < 0.6 + back), 0.03, 0.0)
    r = made_up(load_at(0.5, rise=0.1), off)
    assert away_s(r)[0] == pytest.approx(min(back, 2.4), abs=2e-3)
    assert not_held(r)[0] == loose


def test_within_the_band_is_back() -> None:
    assert not_held(made_up(load_at(0.5), np.full(3000, 0.0199)))[0] == 0.0
    assert not_held(made_up(load_at(0.5), np.full(3000, 0.0201)))[0] == 1.0


def test_after_the_end_of_a_drive_nothing_counts() -> None:
    r = made_up(load_at(0.5), np.where(TIME > 1.5, 0.5, 0.0), live=7500)
    assert away_s(r)[0] == 0.0 and not_held(r)[0] == 0.0


def test_the_clock_starts_where_the_last_change_ends() -> None:
    s = load_at(0.5, rise=0.2)
    s.t[0, 2], s.omega[0, 2:] = 0.6, 20.0  # on a ramp of 1 s; the load still rises until 0.7 s
    s.omega_rate[:] = 20.0
    s.t[0, 3], s.u_dc[0, 3:] = 2.0, 0.9  # within 1 ms
    r = made_up(s, NONE)
    since = since_change(r)[:, 0]
    for t, wanted in ((0.3, 0.3), (0.55, -0.15), (0.65, -0.95), (1.8, 0.2), (2.5, 0.499)):
        assert since[round(1e3 * t)] == pytest.approx(wanted, abs=1e-3), t
    assert reference(r)[1100, 0] == pytest.approx(10.0, abs=0.02)


def test_a_load_of_the_beginning_rises_from_none() -> None:
    s = load_at(2.0, rise=0.2)
    s.tau[:] = MOTOR.tau_rated
    since = since_change(made_up(s, NONE))[:, 0]
    assert since[[100, 300]] == pytest.approx([-0.1, 0.1], abs=1e-3)


def test_a_ramp_that_is_called_back_ends_there() -> None:
    s = load_at(0.5, rise=1.0)
    s.t[0, 2], s.tau[0, 2:] = 1.0, 0.5 * MOTOR.tau_rated
    assert since_change(made_up(s, NONE))[1500, 0] == pytest.approx(0.5, abs=1e-3)


def test_the_start_sequence_is_a_change() -> None:
    r = made_up(load_at(0.5), NONE)
    r.sums["starting"][:200] = 5.0
    assert since_change(r)[300, 0] == pytest.approx(0.1, abs=1e-3)
    assert since_change(r)[100, 0] < 0.0


def test_the_limit_cycle_of_half_the_inertia_is_found() -> None:
    """Rated torque at standstill under pure injection and the SMO: about 6 % at 13 Hz."""
    s = load_at(0.3, rise=0.05)
    for inertia, loose in ((0.5, 1.0), (1.0, 0.0)):
        s.J[:] = inertia
        for policy, wanted in (("eq25", loose), ("sensored", 0.0)):
            r = rollout(make_policy(policy, MOTOR), s, SimFactory(MOTOR, SMO))
            assert r.lost[0] == 0 and not_held(r)[0] == wanted, (inertia, policy)


def test_ordinary_scenarios_hold() -> None:
    factory = SimFactory(MOTOR, DriveDesign())
    scenarios = suite("stress-1", MOTOR, 11, 64)
    for policy in ("eq25", "sensored"):
        r = rollout(make_policy(policy, MOTOR), scenarios, factory)
        assert not not_held(r)[r.lost == 0].any()


@pytest.mark.parametrize(
    "name", ["hold", "crawl", "impact", "stop", "unload", "braking", "sag", "stress-1"]
)
def test_the_sensored_drive_itself_holds_every_suite(name: str) -> None:
    """Its own speed against the reference: within 2 % after 0.5 s, without a swing of 1 %."""
    scenarios = suite(name, MOTOR, 3, 32)
    scenarios.duration[:] = np.minimum(scenarios.duration, 5.0)  # nothing changes later
    r = rollout(make_policy("eq25", MOTOR), scenarios, SimFactory(MOTOR, SMO))
    r.kept["omega_m"] = r.mean("omega_m_twin")
    r.kept["omega_m_twin"] = np.asarray(reference(r), dtype=np.float32)
    whole = r.lost == 0
    assert whole.mean() > 0.9
    assert away_s(r)[whole].max() < 0.5
    r.kept["omega_m_twin"] = np.zeros_like(r.kept["omega_m"])
    assert np.nanmax(swing_pct(r)[whole], initial=0.0) < 1.0

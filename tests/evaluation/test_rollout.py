"""Rollouts: the sums of every decision, in chunks, beside the twin."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, Array, sim_run
from sensorless.core.gains import DEFAULT, GAIN_N, Values
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.errors import UserError
from sensorless.evaluation.rollout import (
    CAUSES,
    Rollout,
    rollout,
    rollouts,
    with_twin_to_the_end,
)
from sensorless.evaluation.trace import outcome, trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import NO_SETTINGS, Settings, Signals

MOTOR = Motor.load("paper")
FACTORY = SimFactory(MOTOR, DriveDesign())


def short(n: int, duration: float = 0.25) -> Scenarios:
    """Random scenarios, cut off."""
    scenarios = stress_1_scenarios(MOTOR, np.arange(1, n + 1, dtype=np.uint64))
    scenarios.duration[:] = duration
    return scenarios


def run(spec: str, scenarios: Scenarios) -> Rollout:
    return rollout(make_policy(spec, MOTOR), scenarios, FACTORY)


class Recorder:
    """Keeps what it was shown, and answers half."""

    name = "recorder"
    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(self) -> None:
        self.drives = 0
        self.seen: list[Signals] = []

    def reset(self, n: int) -> None:
        self.drives = n
        self.seen = []

    def act(self, obs: Signals) -> NDArray[np.float32]:
        self.seen.append(obs)
        return np.full(len(obs), 0.5, dtype=np.float32)


class Crooked(Recorder):
    """One weight too few."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        return super().act(obs)[1:]


def test_the_sums_are_those_of_the_core_decision_by_decision() -> None:
    scenarios = short(3, 0.05)
    r = run("hfi", scenarios)
    sims = FACTORY.build(scenarios)
    obs = np.zeros((3, SIGNAL_N), dtype=np.float32)
    for row in r.sums:
        sim_run(sims, 5, np.ones(3, dtype=np.float32), obs)
        assert row.tobytes() == sims["sums"].tobytes()
    assert len(r.sums) == 50
    assert r.periods.tolist() == [250, 250, 250]
    assert r.lost.tolist() == [0, 0, 0]


def test_a_decision_is_a_millisecond() -> None:
    assert decision_periods(MOTOR) == 5
    assert run("hfi", short(1)).decision_time == pytest.approx(0.001)


def test_chunks_give_the_same_bits_as_one_batch() -> None:
    scenarios = short(7)
    policy = make_policy("hysteresis:100,200", MOTOR)
    whole = rollout(policy, scenarios, FACTORY)
    parts = list(rollouts(policy, scenarios, FACTORY, chunk=3))
    assert [len(p.lost) for p in parts] == [3, 3, 1]
    assert np.concatenate([p.sums for p in parts], axis=1).tobytes() == whole.sums.tobytes()
    assert np.concatenate([p.lost for p in parts]).tolist() == whole.lost.tolist()


def test_a_lost_drive_leaves_no_numbers_behind() -> None:
    r = run("smo", short(12, 1.0))
    lost = np.flatnonzero(r.lost)
    assert 0 < len(lost) < 12
    np.testing.assert_array_equal(r.sums["n"].sum(axis=0), r.periods)
    for j in lost:
        end = -(-int(r.periods[j]) // 5)
        assert end < len(r.sums)
        assert not any(r.sums[end:, j].tobytes())
        assert np.isnan(r.mean("omega_m")[end:, j]).all()
        assert np.isfinite(r.mean("omega_m")[:end, j]).all()


def test_scenarios_of_different_length_end_at_their_own_time() -> None:
    scenarios = short(2)
    scenarios.duration[:] = [0.1, 0.0506]
    r = run("hfi", scenarios)
    assert r.periods.tolist() == [500, 253]
    assert r.sums["n"][:, 1].tolist() == [5.0] * 50 + [3.0] + [0.0] * 49
    assert r.lost.tolist() == [0, 0]


def test_with_the_true_angle_a_drive_is_its_twin() -> None:
    r = run("sensored", short(6))
    assert not r.sums["dev_sq"].any()
    assert not r.sums["err_sq"].any()
    np.testing.assert_array_equal(r.sums["tau"], r.sums["tau_twin"])


def test_what_stopped_a_drive_is_kept() -> None:
    factory = SimFactory(replace(MOTOR, i_trip=0.3), DriveDesign())
    r = rollout(make_policy("sensored", MOTOR), short(6), factory)
    both = CAUSES["current"] | CAUSES["twin"]
    assert both in r.lost.tolist()
    assert set(r.lost.tolist()) <= {0, both}


def test_the_twin_does_not_depend_on_the_policy() -> None:
    scenarios = short(4)
    a, b = run("hfi", scenarios), run("eq25", scenarios)
    both = a.alive & b.alive
    np.testing.assert_array_equal(a.sums["tau_twin"][both], b.sums["tau_twin"][both])
    assert not np.array_equal(a.sums["tau"][both], b.sums["tau"][both])


def test_a_policy_is_reset_and_sees_the_start_before_its_first_answer() -> None:
    scenarios = short(5, 0.02)
    policy = Recorder()
    r = rollout(policy, scenarios, FACTORY)
    assert policy.drives == 5
    assert len(policy.seen) == len(r.sums) == 20
    rated = MOTOR.omega_m_rated
    speed = policy.seen[0][:, SIGNAL_NAMES.index("speed")]
    np.testing.assert_allclose(speed, np.abs(scenarios.omega_0) / rated, rtol=1e-5)
    assert not np.shares_memory(policy.seen[0], policy.seen[1])


@pytest.mark.parametrize("weight", [np.nan, np.inf, -0.1, 1.5])
def test_a_weight_out_of_range_is_no_result(weight: float) -> None:
    """The core would take another one in its place."""
    policy = Recorder()
    policy.act = lambda obs: np.full(len(obs), weight, np.float32)  # type: ignore[method-assign]
    with pytest.raises(UserError, match=f"policy recorder: act gave {weight:g}; give 0 to 1"):
        rollout(policy, short(5, 0.02), FACTORY)


@pytest.mark.parametrize(
    ("shape", "value", "said"),
    [((5, GAIN_N), np.nan, "nan; give -1 to 1"), ((5, GAIN_N), 7.0, "7; give -1 to 1"),
     ((1, GAIN_N), 0.0, "shape"), ((5, 1), 0.0, "shape")],
)  # fmt: skip
def test_a_wrong_gain_is_no_result(shape: tuple[int, int], value: float, said: str) -> None:
    """The core would clip it, or take the static gain in its place."""

    class Gains(Recorder):
        ranges = DEFAULT

        def act_gains(self, obs: Signals) -> Values:
            return np.full(shape, value, np.float32)

    with pytest.raises(UserError, match=f"policy recorder: act_gains gave {said}"):
        rollout(Gains(), short(5, 0.02), FACTORY)


def test_a_weight_rounded_beyond_the_range_is_clipped() -> None:
    """The core takes 1, all injection, in the place of one below 0."""

    def run(k_s: float) -> Array:
        policy = Recorder()
        policy.act = lambda obs: np.full(len(obs), k_s, np.float32)  # type: ignore[method-assign]
        return rollout(policy, short(5, 0.02), FACTORY).sums

    assert np.array_equal(run(-1e-6), run(0.0)) and not np.array_equal(run(0.0), run(1.0))


def test_a_policy_with_the_wrong_number_of_weights_is_stopped() -> None:
    with pytest.raises(UserError, match="policy recorder: act gave shape"):
        rollout(Crooked(), short(3), FACTORY)


def test_totals_are_means_over_all_periods() -> None:
    r = run("eq25", short(3))
    sums: Array = r.sums["tau"].sum(axis=0, dtype=np.float64)
    np.testing.assert_allclose(r.total("tau"), sums / 1250.0)


def test_causes_are_bits_under_the_names_that_results_use() -> None:
    assert CAUSES == {"angle": 1, "current": 2, "nonfinite": 4, "twin": 8}


def test_a_trace_is_the_rollout_period_by_period() -> None:
    """Also for a rule that looks at the sums of the last decision."""
    scenarios = short(1, 0.4)
    table = trace(make_policy("oracle", MOTOR), scenarios, MOTOR, DriveDesign())
    r = run("oracle", scenarios)
    periods = decision_periods(MOTOR)
    k_s = table["k_s"].reshape(-1, periods).mean(axis=1)
    assert np.ptp(k_s) > 0.2
    np.testing.assert_allclose(k_s, r.sums["k_s"][:, 0] / r.sums["n"][:, 0], rtol=1e-6, atol=1e-6)


def overloaded(torque: float) -> Scenarios:
    """Rated speed, then a load of so many times rated torque that pushes backwards."""
    s = Scenarios.nominal(MOTOR, np.array([5], dtype=np.uint64), 1.5)
    s.omega_0[:] = s.omega[:] = 0.5 * MOTOR.omega_rated / MOTOR.n_p
    s.t[:, 1] = 0.1
    s.tau[:, 1:] = torque * MOTOR.tau_rated
    return s


@pytest.mark.parametrize("policy", ["eq25", "smo", "constant:1", "sensored"])
def test_what_no_drive_can_do_is_not_feasible(policy: str) -> None:
    """Three times rated torque: the speed runs away, whatever the angle; lost first or not."""
    r = with_twin_to_the_end(run(policy, overloaded(3.0)), FACTORY)
    assert not r.feasible[0]
    held = with_twin_to_the_end(run(policy, overloaded(0.5)), FACTORY)
    assert held.feasible[0]


def test_a_twin_that_runs_away_is_seen_at_its_bound_and_called_so() -> None:
    """Without a trip in its way, at two and a half times rated speed."""
    strong = replace(MOTOR, i_trip=1000.0)
    t = trace(make_policy("sensored", strong), overloaded(3.0), strong, DriveDesign())
    assert outcome(t).startswith("not feasible")
    bound = 2.5 * MOTOR.omega_rated / MOTOR.n_p
    assert abs(t["omega_m"][-1]) == pytest.approx(bound, rel=0.05)
    held = trace(make_policy("eq25", MOTOR), overloaded(0.5), MOTOR, DriveDesign())
    assert outcome(held) == "kept lock"


def test_feasible_does_not_depend_on_when_the_policy_was_lost() -> None:
    """A drive lost before its twin runs away ran an infeasible scenario all the same."""
    early = overloaded(3.0)
    early.theta_err_0[:] = np.pi
    r = run("smo", early)
    assert r.lost[0] != 0 and r.lost[0] & CAUSES["twin"] == 0, "lost before"
    assert not with_twin_to_the_end(r, FACTORY).feasible[0]

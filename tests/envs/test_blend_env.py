import copy
import pickle
import warnings
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env, data_equivalence

from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.privileged import N_PRIVILEGED, PRIVILEGED
from sensorless.envs.reward import TERMS, RewardWeights
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import nominal_scenarios, stress_1_scenarios
from sensorless.envs.scenarios.suites import SUITES
from sensorless.envs.window_reward import WindowWeights
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
SEED = np.array([1], dtype=np.uint64)


def astray() -> Scenarios:
    """Estimators that start 115 degrees off: lost after 10 ms."""
    scenario = Scenarios.nominal(MOTOR, SEED, 1.0)
    scenario.theta_err_0[:] = 2.0
    return scenario


def same(a: Any, b: Any) -> bool:
    return data_equivalence(a, b, exact=True)


def test_gymnasium_checker_finds_nothing() -> None:
    env = gymnasium.make("sensorless:sensorless/Blend-v0").unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env)


def test_stable_baselines3_checker_finds_nothing() -> None:
    from stable_baselines3.common.env_checker import check_env as check_sb3_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_sb3_env(BlendEnv())


def test_step_returns_plain_types_and_named_terms() -> None:
    env = BlendEnv()
    env.reset(seed=3)
    for _ in range(20):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        assert env.observation_space.contains(observation)
        assert (type(reward), type(terminated), type(truncated)) == (float, bool, bool)
        assert reward == pytest.approx(sum(info[name] for name in TERMS), rel=1e-5)
        assert info["privileged"].shape == (N_PRIVILEGED,) == (len(PRIVILEGED),)


def test_lost_lock_terminates_and_costs() -> None:
    env = BlendEnv()
    _, info = env.reset(seed=1, options={"scenario": astray()})
    assert info["privileged"][:3] == pytest.approx(2.0 * 6.0 / np.pi)
    ends = [env.step([1.0])[2:4] for _ in range(10)]
    assert ends == [(False, False)] * 10
    _, reward, terminated, truncated, info = env.step([1.0])
    assert terminated and info["lost"] and not truncated
    assert info["lost_penalty"] == -RewardWeights().lost > reward
    assert env.step([1.0])[1] == 0.0, "the penalty comes once"


def test_end_of_scenario_truncates() -> None:
    env = BlendEnv()
    env.reset(seed=1, options={"scenario": Scenarios.nominal(MOTOR, SEED, 0.0104)})
    ends = [env.step([1.0])[2:4] for _ in range(11)]
    assert ends == [(False, False)] * 10 + [(False, True)]


def test_twin_that_trips_truncates_without_penalty() -> None:
    env = BlendEnv()
    env.reset(seed=1)
    state = env.state()
    state.sims["twin"]["y"]["i_d"] = 2.0 * MOTOR.i_trip
    env.restore(state)
    _, _, terminated, truncated, info = env.step([1.0])
    assert truncated and not terminated and not info["lost"] and info["lost_penalty"] == 0.0


def test_max_episode_steps() -> None:
    env = BlendEnv(max_episode_steps=3)
    env.reset(seed=1)
    assert [env.step([1.0])[3] for _ in range(3)] == [False, False, True]
    wrapped = gymnasium.make("sensorless/Blend-v0", max_episode_steps=2)
    wrapped.reset(seed=1)
    assert [wrapped.step(np.ones(1, np.float32))[3] for _ in range(2)] == [False, True]


def test_action_is_the_weight() -> None:
    """The weight in force, observed as k_s, runs to (action + 1) / 2 with its slope limit."""
    env = BlendEnv()
    at = [s.name for s in PRIVILEGED].index("theta_e_err")
    env.reset(seed=1, options={"scenario": Scenarios.nominal(MOTOR, SEED, 1.0)})
    for action in (1.0, 0.5, 0.0, 1.0):
        for _ in range(20):
            observation, *_, info = env.step(np.array([action]))
        assert observation[6] == pytest.approx((action + 1.0) / 2.0, abs=1e-6)
        assert abs(info["privileged"][at]) < 0.2


def test_decision_period_sets_the_step() -> None:
    slow, fast = BlendEnv(decision_period=0.002), BlendEnv()
    a, b = slow.reset(seed=4)[0], fast.reset(seed=4)[0]
    for _ in range(30):
        a = slow.step([0.3])[0]
        fast.step([0.3])
        b = fast.step([0.3])[0]
        assert np.array_equal(a, b)


def test_seed_restarts_the_stream_and_no_seed_goes_on() -> None:
    env, other = BlendEnv(), BlendEnv()
    first = [env.reset(seed=8)[0], env.reset()[0], env.reset()[0]]
    again = [env.reset(seed=8)[0], env.reset()[0], env.reset()[0]]
    assert np.array_equal(first, again)
    for a, b in ((0, 1), (1, 2), (0, 2)):
        assert not np.array_equal(first[a], first[b])
    assert not np.array_equal(env.reset()[0], other.reset()[0]), "unseeded environments differ"


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_continue_identically(clone: Any) -> None:
    env = BlendEnv(max_episode_steps=30)
    env.reset(seed=5)
    for _ in range(10):
        env.step([0.2])
    twin = clone(env)
    for _ in range(20):
        assert same(env.step([-0.2]), twin.step([-0.2]))
    assert same(env.reset(), twin.reset())


@pytest.mark.parametrize("name", [name for name in SUITES if name != "envelope"])
def test_a_suite_by_name_is_an_endless_stream(name: str) -> None:
    """Each scenario follows from its seed, and another seed gives another."""
    env = BlendEnv(scenarios=name)
    seen = []
    for seed in (3, 3, 4):
        env.reset(seed=seed)
        seen.append(env.state().sims.tobytes())
    assert seen[0] == seen[1] != seen[2]
    assert "nan" not in str(env.step([1.0])[0])


@pytest.mark.parametrize("value", ["envelope", "no-such", 3])
def test_what_is_no_stream_is_refused(value: object) -> None:
    with pytest.raises(UserError, match=r"scenarios: .*(choose from paper|a suite by name)"):
        BlendEnv(scenarios=value)


def test_restore_goes_back() -> None:
    env = BlendEnv()
    env.reset(seed=5)
    before = env.step([1.0])[0]
    state = env.state()
    one = [env.step([0.1]) for _ in range(30)] + [env.reset()]
    env.restore(state)
    assert np.array_equal(env.batch.observation()[0], before)
    two = [env.step([0.1]) for _ in range(30)] + [env.reset()]
    assert same(one, two)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"motor": "ebike_hub"}, "state: motor: it was made with 'paper, digest .*'ebike_hub"),
        (
            {"decision_period": 2e-3},
            "state: decision_period: .* with 0.001, .* with 0.002",
        ),
        ({"design": DriveDesign(speed_hz=3.0)}, "state: speed_hz: .*; restore it where they are"),
        ({"weights": WindowWeights()}, "state: weights: .*'RewardWeights', .*'WindowWeights'"),
        ({"weights": RewardWeights(lost=5.0)}, r"state: weights\.lost: .* 1000.0, .* with 5.0"),
        ({"scenarios": nominal_scenarios}, "state: scenarios: .*stress_1_scenarios', .*nominal"),
        ({"max_episode_steps": 7}, "state: max_episode_steps: it was made with None, .* with 7"),
    ],
)
def test_a_state_of_other_settings_is_refused(settings: dict[str, Any], message: str) -> None:
    env, other = BlendEnv(), BlendEnv(**settings)
    env.reset(seed=5)
    with pytest.raises(UserError, match=message):
        other.restore(env.state())
    with pytest.raises(UserError, match="state: None; restore what state"):
        other.restore(None)  # type: ignore[arg-type]


def test_a_limit_of_steps_may_be_large() -> None:
    env = BlendEnv(max_episode_steps=2**40)
    env.reset(seed=5)
    assert not env.step([0.0])[3]


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([1.5], r"action\[0\]: 1.5; give -1 to 1"),
        ([-1.0001], r"action\[0\]: -1.0001; give -1 to 1"),
        ([np.nan], r"action\[0\]: nan; give -1 to 1"),
        ([np.inf], r"action\[0\]: inf; give -1 to 1"),
        ([0.0, 0.0], r"action: shape \(2,\); give shape \(1,\)"),
        ("a", r"action: array\('a', .*; give numbers of shape \(1,\)"),
        ({}, r"action: array\(\{\}, .*; give numbers of shape \(1,\)"),
        ([1j], r"action: array\(\[0.*1.j\]\); give numbers of shape \(1,\)"),
        ([10**400], r"action: array\(\[10.*; give numbers of shape \(1,\)"),
    ],
)
def test_bad_action_is_refused(action: object, message: str) -> None:
    env = BlendEnv()
    env.reset(seed=1)
    before = env.state().sims
    with pytest.raises(UserError, match=message):
        env.step(np.array(action))
    assert np.array_equal(before, env.state().sims), "nothing moved"


def test_a_scenario_may_last_for_ever() -> None:
    env = BlendEnv()
    scenario = replace(stress_1_scenarios(env.batch.motor, np.array([1])), duration=np.array([1e9]))
    env.reset(options={"scenario": scenario})
    assert not any(any(env.step([1.0])[2:4]) for _ in range(3))


def test_step_before_reset_is_refused() -> None:
    with pytest.raises(ResetNeeded):
        BlendEnv().step([0.0])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"decision_period": float("nan")},
            "decision_period: nan: must be a finite number",
        ),
        ({"decision_period": 0.0}, "decision_period: 0.0: must be between"),
        ({"max_episode_steps": 0}, "max_episode_steps: 0: must be"),
        ({"max_episode_steps": 1.5}, "max_episode_steps: 1.5: must be"),
        ({"motor": "no_such_motor"}, "no_such_motor"),
        ({"estimator": "smo"}, r"estimator: 'smo': .*design=DriveDesign\(estimator='smo'\) of"),
        ({"design": 3}, r"design: 3; give a DriveDesign, such as"),
        ({"colour": 3}, "colour: 3: is unknown; choose from motor, design"),
        ({"motor": 3}, "motor: 3; give the name of a shipped machine, a TOML file, or a Motor"),
        ({"scenarios": 1}, "scenarios: 1; give a suite by name, or a function"),
    ],
)
def test_bad_settings_are_named(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        BlendEnv(**settings)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"seed": -1}, "seed: -1; give"),
        (
            {"options": {"scenarios": None}},
            "options: 'scenarios' is unknown; the only option is 'scenario'",
        ),
        ({"options": 3}, "options: 3; give None or"),
        ({"options": []}, r"options: \[\]; give None or"),
        ({"options": {"scenario": 7}}, r"options\['scenario'\]: 7; give"),
        (
            {"options": {"scenario": Scenarios.nominal(MOTOR, SEED.repeat(2), 1.0)}},
            r"options\['scenario'\]: 2 rows; give Scenarios with 1 rows",
        ),
    ],
)
def test_bad_reset_is_named(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        BlendEnv().reset(**arguments)


def test_motor_and_design_reach_the_drive() -> None:
    plain = BlendEnv()
    other = BlendEnv(motor=MOTOR, design=DriveDesign(signal_hz=60.0))
    assert np.array_equal(plain.reset(seed=2)[0], other.reset(seed=2)[0])
    assert not np.array_equal(plain.step([0.0])[0], other.step([0.0])[0])

"""``sensorless/Blend-v1``: k_s and gains, and a reward over a fixed window."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import sensorless  # noqa: F401
from sensorless.core.gains import Gain
from sensorless.envs.blend_settings import GainSettings
from sensorless.envs.blend_v1 import GainEnv, GainVectorEnv
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.signals import Observation
from sensorless.envs.window_reward import WindowWeights
from sensorless.errors import UserError


def eq25(obs: Observation) -> Observation:
    k_s = (0.8 / 3.0 - obs[:, 0]) / (0.2 / 3.0)
    actions: Observation = (2.0 * np.clip(k_s, 0.0, 1.0) - 1.0).astype(np.float32)[:, None]
    return actions


def test_gymnasium_accepts_it() -> None:
    check_env(gymnasium.make("sensorless/Blend-v1", render_mode="rgb_array").unwrapped)


def test_gains_at_zero_are_the_static_drive() -> None:
    with_gains = GainVectorEnv(20)
    alone = BlendVectorEnv(20, decision_period=5e-3, weights=WindowWeights())
    a, b = with_gains.reset(seed=4)[0], alone.reset(seed=4)[0]
    for _ in range(150):
        k_s = eq25(b)
        a, reward_a, *_ = with_gains.step(np.concatenate([k_s, np.zeros((20, 4))], axis=1))
        b, reward_b, *_ = alone.step(k_s)
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(reward_a, reward_b)


def test_single_drives_are_rows_of_the_vector_form() -> None:
    names = ("amplitude", "observer")
    many = GainVectorEnv(3, gains=names)
    single = [GainEnv(gains=names) for _ in range(3)]
    assert single[0].action_space.shape == (3,)
    rows, _ = many.reset(seed=8)
    one = [env.reset(seed=8 + i)[0] for i, env in enumerate(single)]
    rng = np.random.default_rng(0)
    for _ in range(60):
        np.testing.assert_array_equal(rows, np.stack(one))
        actions = rng.uniform(-1, 1, (3, 3)).astype(np.float32)
        actions[:, 0] = eq25(rows)[:, 0]
        rows, reward, *_ = many.step(actions)
        steps = [env.step(a) for env, a in zip(single, actions, strict=True)]
        one = [s[0] for s in steps]
        np.testing.assert_array_equal(reward, np.array([s[1] for s in steps], np.float32))


def test_each_gain_changes_the_drive() -> None:
    ends = {}
    for name in ("none", "observer", "injection", "l_q", "amplitude"):
        env = GainVectorEnv(4, gains=() if name == "none" else (name,))
        obs, _ = env.reset(seed=2)
        for _ in range(80):
            action = eq25(obs)
            if name != "none":
                action = np.concatenate([action, np.full((4, 1), -1.0)], axis=1)
            obs, *_ = env.step(action)
        ends[name] = obs.tobytes()
    assert len(set(ends.values())) == 5


def test_a_snapshot_continues_to_the_bit() -> None:
    env = GainVectorEnv(3)
    env.reset(seed=5)
    for _ in range(10):
        env.step(np.full((3, 5), -0.5))
    state = env.state()
    first = [env.step(np.full((3, 5), 0.4))[:2] for _ in range(8)]
    env.restore(state)
    again = [env.step(np.full((3, 5), 0.4))[:2] for _ in range(8)]
    for (a, r), (b, s) in zip(first, again, strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(r, s)


def test_a_return_does_not_depend_on_the_decision_period() -> None:
    """The same weights at the same times, decided on every 5 ms and told every 1 ms."""
    slow, fast = GainVectorEnv(12, gains=()), GainVectorEnv(12, gains=(), decision_period=1e-3)
    obs, _ = slow.reset(seed=21)
    fast.reset(seed=21)
    earned = np.zeros((2, 12))
    for _ in range(300):
        action = eq25(obs)
        obs, reward, *_ = slow.step(action)
        earned[0] += reward
        for _ in range(5):
            earned[1] += fast.step(action)[1]
    assert earned.max() < -0.5
    np.testing.assert_allclose(earned[0].sum(), earned[1].sum(), rtol=0.03)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"gains": ("torque",)}, "'torque' is unknown; choose from observer"),
        ({"gains": ("l_q", "l_q")}, "name each gain once"),
        ({"gains": 3}, "gains: 3; give a tuple of names"),
        ({"gains": None}, "gains: None; give a tuple of names"),
        ({"gains": (["l_q"],)}, r"gains: \['l_q'\] is unknown; choose from"),
        ({"gain_ranges": None}, "gain_ranges: None; give a Gain by name"),
        ({"gains": (), "gain_ranges": {"l_q": Gain(0.9, 1.1)}}, r"'l_q' is not in gains = \(\)"),
        ({"gain_ranges": {"x": None}}, "'x' is unknown"),
        ({"gain_ranges": {"l_q": (0.9, 1.1)}}, r"gain_ranges: l_q: \(0.9, 1.1\); give .*Gain\(low"),
        ({"gain_ranges": {"l_q": Gain(1.1, 0.9)}}, r"l_q: Gain\(low=1.1, high=0.9.*at most 1"),
        ({"gain_ranges": {"l_q": Gain(float("nan"), 2.0)}}, "l_q: Gain.low=nan"),
        ({"gain_ranges": {"l_q": Gain(0.5, 8.0)}}, "so that a parabola through 1 only rises"),
    ],
)
def test_unknown_gains_are_refused(settings: dict[str, object], words: str) -> None:
    with pytest.raises(UserError, match=words):
        GainSettings(**settings)  # type: ignore[arg-type]


def test_a_state_of_other_gains_is_refused() -> None:
    env, other = GainEnv(gains=()), GainEnv(gains=("l_q",))
    env.reset(seed=5)
    with pytest.raises(UserError, match=r"state: gains: it was made with {}, .* with {'l_q': "):
        other.restore(env.state())


def test_version_0_sets_k_s_alone() -> None:
    with pytest.raises(UserError, match=r"gains: .* unknown"):
        gymnasium.make("sensorless/Blend-v0", gains=("observer",))


@pytest.mark.filterwarnings("ignore:.*render_mode='ansi'")  # Gymnasium's own, before the error
@pytest.mark.parametrize("env_id", ["sensorless/Blend-v0", "sensorless/Blend-v1"])
def test_a_wrong_render_mode_is_refused(env_id: str) -> None:
    with pytest.raises(UserError, match="render_mode: 'ansi'; choose from None, 'rgb_array'"):
        gymnasium.make(env_id, render_mode="ansi")


def test_an_action_past_one_by_rounding_is_clipped() -> None:
    env = GainVectorEnv(2)
    env.reset(seed=1)
    one = np.full((2, 5), np.nextafter(np.float32(1.0), np.float32(2.0)))
    env.step(one)
    with pytest.raises(UserError, match="give -1 to 1"):
        env.step(np.full((2, 5), 1.01))
    wrong = np.zeros((2, 5))
    wrong[1, 3] = 5.0
    with pytest.raises(UserError, match=r"action\[1\]\[3\]: 5.0; give -1 to 1$"):
        env.step(wrong)


def test_a_picture_shows_the_run() -> None:
    env = GainEnv(render_mode="rgb_array")
    env.reset(seed=3)
    empty = env.render()
    for _ in range(30):
        env.step(np.zeros(5, np.float32))
    picture = env.render()
    assert picture is not None and picture.shape == (200, 320, 3) and picture.dtype == np.uint8
    assert (picture != empty).any()

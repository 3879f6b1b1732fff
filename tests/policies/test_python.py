"""A user's policy by MODULE:NAME: it runs like a rule, and every mistake is told in one line."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N
from sensorless.core.gains import GAIN_N, Gain
from sensorless.envs.blend_settings import GainSettings
from sensorless.envs.signals import HIGH, LOW
from sensorless.errors import UserError
from sensorless.evaluation.certify import certify
from sensorless.machine.motor import Motor
from sensorless.policies.bench import bench
from sensorless.policies.python import PythonPolicy
from sensorless.policies.registry import make_policy
from sensorless.policy import GainPolicy, gains_of

PAPER = Motor.load("paper")
OBS = np.linspace(-1.0, 1.0, 3 * SIGNAL_N, dtype=np.float32).reshape(3, SIGNAL_N)
CODE = """
import numpy as np

NUMBER = 7

class Half:
    settings = {"estimator": "smo"}
    def __init__(self, motor):
        self.rated = motor.n_rated_rpm
    def act(self, obs):
        return [0.5] * len(obs)

def failing(motor):
    raise KeyError("no such weight")

def nothing(motor):
    return None

def no_motor():
    return Half(None)
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a module with ``CODE`` in the working directory; each test has its own name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", ["elsewhere"])
    name = f"own_{abs(hash(str(tmp_path)))}"
    (tmp_path / f"{name}.py").write_text(CODE)
    return name


def test_it_runs_where_a_rule_runs(module: str) -> None:
    policy = make_policy(f"{module}:Half", PAPER)
    policy.reset(3)
    weights = policy.act(OBS)
    assert (policy.name, policy.settings) == ("Half", {"estimator": "smo"})
    assert weights.dtype == np.float32 and weights.tolist() == [0.5, 0.5, 0.5]
    on = bench([f"{module}:Half", "constant:0.5"])
    own, rule = on.policies([f"{module}:Half", "constant:0.5"]).values()
    rule.settings = own.settings
    counts = [certify(p, PAPER, on.design, "stress-1", 3, 4) for p in (own, rule)]
    assert counts[0]["acts"] == counts[1]["acts"] and counts[0]["lost"] == counts[1]["lost"]


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("nowhere_at_all:Half", "no module 'nowhere_at_all' in this folder"),
        ("{}:Other", "has no 'Other'; it has Half, failing, no_motor, nothing"),
        ("{}:NUMBER", "is an object of type int; name a class or a function"),
        ("{}:failing", "fails in failing(motor): KeyError: 'no such weight'"),
        ("{}:no_motor", "fails in no_motor(motor): TypeError"),
        ("{}:nothing", "gave None, not a policy; give it act(obs)"),
        ("{}_broken:Half", "fails in import: SyntaxError"),
        ("{}_needs:Half", "fails in import: ModuleNotFoundError: No module named 'not_installed'"),
        ("{}_ends:Half", "fails in import: SystemExit: 0"),
    ],
)
def test_a_word_that_gives_no_policy(module: str, word: str, said: str) -> None:
    Path(f"{module}_broken.py").write_text("def act(:\n")
    Path(f"{module}_needs.py").write_text("import not_installed\n")
    Path(f"{module}_ends.py").write_text("raise SystemExit(0)  # a script without a main guard\n")
    with pytest.raises(UserError) as caught:
        make_policy(word.format(module), PAPER)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_an_error_names_file_and_line(module: str) -> None:
    with pytest.raises(UserError, match=rf"{module}\.py:14\)"):
        make_policy(f"{module}:failing", PAPER)


def own(**parts: object) -> PythonPolicy:
    """Policy of an object with these attributes."""
    act = {"act": lambda self, obs: np.zeros(len(obs))}
    return PythonPolicy("m:own", type("Own", (), {**act, **parts})())


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (np.zeros((3, 1)), r"shape (3, 1) for 3 drives; give (3,)"),
        (0.5, "shape () for 3 drives"),
        ([0.0, np.nan, 1.0], "gave nan; give 0 to 1"),
        ([0.0, 0.5, np.inf], "gave inf; give 0 to 1"),
        ([-1.0, 0.0, 1.0], "gave -1; give 0 to 1"),
        ([0.0, 0.0, 1.1], "gave 1.1; give 0 to 1"),
        ("half", "fails in act: ValueError"),
    ],
)
def test_an_answer_that_is_no_weight(answer: object, said: str) -> None:
    with pytest.raises(UserError) as caught:
        own(act=lambda self, obs: answer).act(OBS)
    assert said in str(caught.value)


def test_one_that_ends_the_program_is_an_error() -> None:
    """The command would end in status 0, without a result."""

    def act(self: object, obs: object) -> None:
        raise SystemExit(0)

    with pytest.raises(UserError, match="fails in act: SystemExit: 0"):
        own(act=act).act(OBS)


def test_rounding_beyond_the_range_is_clipped() -> None:
    assert own(act=lambda self, obs: [-1e-7, 1.0 + 1e-6, 0.5]).act(OBS).tolist() == [0.0, 1.0, 0.5]


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({"act": 1}, "give it act(obs)"),
        ({"sensored": True}, "asks for the truth"),
        ({"act_knowing": lambda self, obs, sims: 0}, "asks for the truth"),
        ({"name": 3}, "name: 3; give text"),
        ({"name": "two\nlines"}, "name: 'two\\nlines'; give text of one line"),
        ({"name": property(lambda self: 1 / 0)}, "fails in its attributes: ZeroDivisionError"),
        ({"settings": ["smo"]}, "settings: an object of type list"),
        ({"settings": {"observer": "smo"}}, "settings: 'observer' is unknown; sensorless settings"),
        ({"settings": {"estimator": "best"}}, "estimator: 'best'"),
        ({"ranges": {"l_q": Gain(0.8, 1.25)}}, "has ranges without act_gains(obs); give both"),
        ({"act_gains": lambda self, obs: obs}, "has act_gains without ranges; give both"),
        ({"ranges": [Gain(0.8, 1.25)]}, "ranges: [Gain(low=0.8, "),
    ],
)
def test_parts_of_the_wrong_kind(parts: dict[str, object], said: str) -> None:
    with pytest.raises(UserError) as caught:
        own(**parts)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("ranges", "said"),
    [
        ({"l_q": (0.8, 1.25)}, "ranges: l_q: (0.8, 1.25); give sensorless.core.gains.Gain(low, "),
        ({"L_q": Gain(0.8, 1.25)}, "ranges: 'L_q' is unknown; choose from observer"),
        ({"l_q": Gain(0.0, 1.0)}, "ranges: l_q: Gain(low=0.0, high=1.0"),
        ({"l_q": Gain(-1.0, np.inf)}, "high=inf"),
        ({"l_q": Gain(2.0, 3.0)}, "low above 0 and at most 1"),
        ({"l_q": Gain(3.0, 0.3)}, "high at least 1"),
        ({"l_q": Gain(0.5, 2.6)}, "so that a parabola through 1 only rises"),
        ({"l_q": Gain(0.8, 1.25, 0.0)}, "settle above 0"),
        ({"l_q": Gain("low", 1.25)}, "Gain(low='low'"),  # type: ignore[arg-type]
    ],
)
def test_ranges_are_those_that_the_environment_takes(ranges: dict[str, Gain], said: str) -> None:
    with pytest.raises(UserError) as caught:
        own(ranges=ranges, act_gains=lambda self, obs: np.zeros((len(obs), GAIN_N)))
    assert said in str(caught.value)
    with pytest.raises(UserError, match=r"give sensorless\.core\.gains\.Gain|is unknown; choose"):
        GainSettings(gains=tuple(ranges), gain_ranges=ranges)


def test_it_may_set_gains() -> None:
    ranges = {"l_q": Gain(0.8, 1.25)}
    policy = own(ranges=ranges, act_gains=lambda self, obs: np.zeros((len(obs), GAIN_N)))
    assert isinstance(policy, GainPolicy) and gains_of(policy) == ranges
    assert policy.act_gains(OBS).shape == (3, GAIN_N)
    loud = own(ranges=ranges, act_gains=lambda self, obs: np.full((len(obs), GAIN_N), 2.0))
    with pytest.raises(UserError, match="act_gains gave 2; give -1 to 1"):
        loud.act_gains(OBS)


def test_signals_are_a_copy_within_the_bounds_of_an_environment() -> None:
    """A policy may write into them; drives that are lost run on beyond the bounds."""
    seen = []

    def act(self: object, obs: np.ndarray) -> np.ndarray:
        seen.append(obs.copy())
        obs[:] = 0.0
        return np.ones(len(obs))

    given = 50.0 * OBS
    before = given.copy()
    own(act=act).act(given)
    assert given.tolist() == before.tolist()
    assert (LOW <= seen[0]).all() and (seen[0] <= HIGH).all() and seen[0].min() < 0.0

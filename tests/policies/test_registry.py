"""Policies by name, and what is said about names that are none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.baselines.hysteresis import Hysteresis
from sensorless.baselines.linear import linear_table
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, SIM
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies import shipped
from sensorless.policies.registry import PYTHON, RULES, RUN, TUNED, known, make_policy, rule_named
from sensorless.policy import decide

PAPER = Motor.load("paper")


def weights(spec: str, speeds_rpm: list[float], motor: Motor = PAPER) -> list[float]:
    """First answer of a policy to drives at these speeds."""
    policy = make_policy(spec, motor)
    obs = np.zeros((len(speeds_rpm), SIGNAL_N), dtype=np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = np.array(speeds_rpm) / motor.n_rated_rpm
    policy.reset(len(obs))
    return [round(float(x), 4) for x in policy.act(obs)]


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("eq25", [1.0, 0.75, 0.5, 0.0]),
        ("linear", [1.0, 0.75, 0.5, 0.0]),
        ("linear:300,400", [1.0, 0.75, 0.5, 0.0]),
        ("linear:hi=500", [1.0, 0.875, 0.75, 0.25]),
        ("linear:200,400", [0.75, 0.375, 0.25, 0.0]),
        ("linear:0,325", [0.2308, 0.0, 0.0, 0.0]),
        ("hysteresis", [1.0, 1.0, 1.0, 0.0]),
        ("hysteresis:280,320", [1.0, 0.0, 0.0, 0.0]),
        ("constant:0.25", [0.25, 0.25, 0.25, 0.25]),
        ("constant:1", [1.0, 1.0, 1.0, 1.0]),
        ("hfi", [1.0, 1.0, 1.0, 1.0]),
        ("smo", [0.0, 0.0, 0.0, 0.0]),
    ],
)
def test_weights_at_250_to_380_r_min(spec: str, expected: list[float]) -> None:
    speeds = [250.0, 325.0, 350.0, 450.0]
    assert weights(spec, speeds) == expected
    policy = make_policy(spec, PAPER)
    assert policy.name == spec
    assert not policy.sensored


def test_the_gap_of_the_hysteresis_is_5_percent_around_350_r_min() -> None:
    policy = make_policy("hysteresis", PAPER)
    assert isinstance(policy, Hysteresis)
    assert policy.low * 1500.0 == pytest.approx(332.5)
    assert policy.high * 1500.0 == pytest.approx(367.5)


def test_a_band_in_r_min_stays_but_the_papers_band_scales_with_the_motor() -> None:
    fast = replace(PAPER, n_rated_rpm=3000.0)
    assert weights("linear:300,400", [350.0, 700.0], fast) == [0.5, 0.0]
    assert weights("eq25", [350.0, 700.0], fast) == [1.0, 0.5]


def test_sensored_asks_for_the_true_angle() -> None:
    assert make_policy("sensored", PAPER).sensored


TWO = "give all 2 numbers in order, or some as NAME=VALUE: linear[:LO,HI]"


@pytest.mark.parametrize(
    ("spec", "said"),
    [
        ("linear:", TWO),
        ("linear:400,300", "LO must be below HI"),
        ("linear:300,300", "LO must be below HI"),
        ("linear:-5,300", "lo: -5.0: must be between 0 and 15000 r/min"),
        ("linear:300", TWO),
        ("linear:100,200,300", TWO),
        ("linear:nan,400", "lo: nan: must be a finite number"),
        ("linear:300,inf", "hi: inf: must be a finite number"),
        ("linear:a,b", "lo: 'a': must be a number"),
        ("hysteresis:400,300", "LO must be below HI"),
        ("hysteresis:", "give all 2 numbers"),
        ("constant", "k: '': must be a number between 0 and 1 (weight of injection)"),
        ("constant:1.01", "between 0 and 1"),
        ("constant:-0.1", "between 0 and 1"),
        ("constant:nan", "between 0 and 1"),
        ("constant:0.2,0.3", "give one number: constant:K"),
        ("eq25:300,400", "takes no numbers"),
        ("hfi:1", "takes no numbers"),
        ("smo:", "takes no numbers"),
        ("sensored:1", "takes no numbers"),
        ("gated:1,2,3", "RELEASE"),
        ("tuned:", "tuned:FILE.json"),
    ],
)
def test_bad_numbers_are_refused_with_what_to_do(spec: str, said: str) -> None:
    with pytest.raises(UserError) as caught:
        make_policy(spec, PAPER)
    text = str(caught.value)
    assert repr(spec) in text and said in text and "\n" not in text


def test_an_unknown_name_is_told_the_one_most_like_it_or_every_one() -> None:
    with pytest.raises(UserError, match=r"did you mean fuzzy\? 'sensorless evaluate --list'"):
        make_policy("fuzzzy", PAPER)
    with pytest.raises(UserError, match=r"'liner' .*; did you mean linear\? choose from eq25"):
        rule_named("liner")
    with pytest.raises(UserError) as caught:
        make_policy("nobody", PAPER)
    assert all(name in str(caught.value) for name in (*RULES, TUNED, RUN, PYTHON))
    with pytest.raises(UserError, match="policy: '' is not a rule"):
        make_policy("", PAPER)


def test_every_rule_can_be_made_and_runs() -> None:
    obs = np.zeros((3, SIGNAL_N), dtype=np.float32)
    sims = np.zeros(3, dtype=SIM)
    for name in RULES:
        policy = make_policy("constant:0.5" if name == "constant" else name, PAPER)
        policy.reset(3)
        k_s = decide(policy, obs, sims)
        assert k_s.shape == (3,) and k_s.dtype == np.float32
        assert ((k_s >= 0.0) & (k_s <= 1.0)).all()


def test_the_list_has_a_line_for_everything() -> None:
    words = known()
    named = [word.split("[")[0].split(":")[0] for word in words]
    assert named == [*RULES, *shipped.docs({}), "tuned", RUN, "MODULE"]
    assert all(doc and "\n" not in doc and len(doc) < 90 for doc in words.values())


def test_a_folder_without_a_table_is_no_run(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"table\.json"):
        make_policy(str(tmp_path), PAPER)


def test_a_folder_with_a_table_is_a_run_on_its_own_motor(tmp_path: Path) -> None:
    run = tmp_path / "first"
    run.mkdir()
    linear_table(0.1, 0.2).save(run / "table.json", {"motor_digest": PAPER.digest})
    assert weights(str(run), [150.0, 225.0, 300.0]) == [1.0, 0.5, 0.0]
    assert make_policy(str(run), PAPER).name == "first"
    with pytest.raises(UserError, match="motor"):
        make_policy(str(run), replace(PAPER, J=0.03))


def test_a_table_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "table.json").write_text("{}")
    with pytest.raises(UserError, match=r"table\.json"):
        make_policy(str(tmp_path), PAPER)

"""A scenario that an evaluation lists can be run again, alone, with the same end."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.suites import SUITES, scenario_word, suite
from sensorless.envs.scenarios.words import scenario_from
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import WORST, evaluate
from sensorless.evaluation.trace import lost_cause, trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies, make_policy
from tests.helpers.scenarios import at_most

MOTOR, DESIGN = Motor.load("paper"), DriveDesign(estimator="smo", L_q_motoring=0.7)
"""A drive that loses some scenarios."""


@pytest.fixture(scope="module", autouse=True)
def three_seconds() -> Iterator[None]:
    """At most; a hand-over crosses the band once until then."""
    with at_most(3.0):
        yield


@cache
def entry(name: str, seed: int, size: int, policy: str) -> dict[str, Any]:
    return evaluate(MOTOR, DESIGN, name, seed, size, make_policies([policy], MOTOR)).policies[
        policy
    ]


@pytest.mark.parametrize(
    ("name", "seed", "size", "policy"),
    [("stress-1", 6, 33, "hfi"), ("envelope", 1, 25, "smo"), ("handoff", 3, 8, "gated")],
)
def test_a_replay_ends_as_it_was_judged(name: str, seed: int, size: int, policy: str) -> None:
    listed = entry(name, seed, size, policy)["worst"]
    for case in listed[: 3 if name != "handoff" else 1]:  # of those that remember, the longest
        run = trace(
            make_policy(policy, MOTOR), scenario_from(case["scenario"], MOTOR), MOTOR, DESIGN
        )
        assert lost_cause(run) == case["lost_cause"]
        assert len(run["t"]) * MOTOR.T_s == pytest.approx(case["time_s"], abs=1e-9)
        largest = np.rad2deg(np.abs(run["theta_e_err"]).max())
        assert largest == pytest.approx(case["angle_err_max_deg"], rel=1e-5)
    if name != "handoff":
        assert listed[0]["lost_cause"] and listed[0]["quadrant"]


def test_the_list_is_in_order_and_names_scenarios_of_the_suite() -> None:
    found = entry("stress-1", 6, 33, "hfi")
    rows, listed = found["scenarios"], found["worst"]
    index = [int(case["scenario"].split(":")[2]) for case in listed]
    assert len(listed) == WORST == len(set(index))
    lost = [rows["lost"][i] for i in index]
    assert lost == sorted(lost, reverse=True) and sum(lost) == sum(rows["lost"]) > 0
    assert [rows["lost_cause"][i] for i in index] == [case["lost_cause"] for case in listed]
    kept = [(case["not_held"], case["torque_dev_rms"]) for case in listed if not case["lost_cause"]]
    assert kept == sorted(kept, reverse=True) and kept[0][0] and not kept[-1][0]


@pytest.mark.parametrize("name", list(SUITES))
def test_a_word_is_exactly_its_scenario(name: str) -> None:
    size, index = 16, 11
    whole = suite(name, MOTOR, 5, size)[index : index + 1]
    alone = scenario_from(scenario_word(name, 5, index, size), MOTOR)
    for field, x in vars(whole).items():
        np.testing.assert_array_equal(x, getattr(alone, field), err_msg=field)


@pytest.mark.parametrize(
    "word",
    ["stress-1", "stress-1:7", "stress-1:7:x", "envelope:1:3", "envelope:1:25:25", "none:1:2"],
)
def test_words_that_name_none(word: str) -> None:
    with pytest.raises(UserError, match=r"; (write|append|give|choose)"):
        scenario_from(word, MOTOR)


def test_simulate_replays_and_draws(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = tmp_path / "case.png"
    case = entry("stress-1", 6, 33, "hfi")["worst"][0]
    words = ["simulate", "--scenario", case["scenario"], "--policy", "hfi", "--plot", str(picture)]
    words += ["--set", "estimator=smo", "--set", "L_q_motoring=0.7"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert f"lost ({case['lost_cause']})" in done.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")

"""Scenarios that a report shows in waveforms."""

from collections.abc import Iterator

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies
from sensorless.report.cases import CROSSED, OURS, cases
from tests.helpers.scenarios import at_most

MOTOR, DESIGN = Motor.load("paper"), DriveDesign()


@pytest.fixture(scope="module", autouse=True)
def one_crossing() -> Iterator[None]:
    """Of the two that a scenario has."""
    with at_most(2.5):
        yield


def test_cases_are_the_worst_and_a_typical_hand_over() -> None:
    name = "linear:100,700"
    results = evaluate(MOTOR, DESIGN, "handoff", 7, 12, make_policies([name, "eq25"], MOTOR))
    found = cases(results, name, "eq25")
    worst = results.policies[name]["worst"]
    assert [c.scenario for c in found[:OURS]] == [c["scenario"] for c in worst[:OURS]]
    rows = results.policies[name]["scenarios"]
    crossed = [
        i
        for i in range(12)
        if not rows["lost"][i] and rows["k_s_activity"][i] * rows["time_s"][i] >= CROSSED
    ]
    assert len(crossed) > 2
    middle = sorted(crossed, key=lambda i: rows["torque_p2p_handover"][i])[(len(crossed) - 1) // 2]
    words = [case.scenario for case in found]
    assert f"handoff:7:{middle}" in words
    assert len(set(words)) == len(words)


def test_where_the_weight_never_moves_there_is_no_hand_over() -> None:
    results = evaluate(MOTOR, DESIGN, "handoff", 7, 3, make_policies(["hfi", "eq25"], MOTOR))
    assert not any("hand-over" in case.what for case in cases(results, "hfi", "eq25"))

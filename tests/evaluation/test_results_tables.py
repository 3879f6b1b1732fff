"""The tables behind ``evaluate --details``."""

import io
from dataclasses import replace
from typing import Any

import pytest
from rich.console import Console
from rich.table import Table

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.results import HANDOVER_COLUMNS, Results
from sensorless.evaluation.results_tables import (
    number,
    paired_table,
    place_table,
    rate,
    share,
    worst_table,
)
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies

pytestmark = pytest.mark.usefixtures("short_suites")


@pytest.fixture(scope="module")
def results() -> Results:
    words = ("eq25", "smo", "sensored")
    return evaluate(
        Motor.load("paper"),
        DriveDesign(),
        "stress-1",
        7,
        8,
        make_policies(words, Motor.load("paper")),
    )


def text_of(table: Table) -> str:
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(table)
    return console.export_text()


def cells(text: str, first: str) -> list[str]:
    """Cells of the row that begins with a word."""
    line = next(line for line in text.splitlines() if line.strip("│ ").startswith(first))
    return [cell.strip() for cell in line.strip("│").split("│")]


def test_numbers_and_rates() -> None:
    assert (number(-0.04, 1), number(-1.26, 1), number(float("nan"), 1)) == ("0.0", "−1.3", "–")
    assert rate(0.031, (0.0123, 0.084)) == "3.1 (1.2–8.4)"
    assert rate(0.0, (0.0, 0.0019)) == "0.0 (0.0–0.2)"
    assert rate(float("nan"), (float("nan"), float("nan"))) == "–"


def test_a_share_says_of_what_and_has_a_sign() -> None:
    assert (share(-0.45, 1.0), share(0.25, 2.0), share(0.0, 2.0)) == ("−45 %", "+12 %", "0 %")
    assert share(1.0, 0.0) == share(float("nan"), 1.0) == share(1.0, float("nan")) == ""


def test_places_of_a_policy(results: Results) -> None:
    policy = results.policies["smo"]
    text = text_of(place_table("smo", policy))
    assert max(map(len, text.splitlines())) <= 80
    for block, j, label in (("by_quadrant", 1, "forward regen"), ("by_speed", 0, "speed 0–5 %")):
        row, x = cells(text, label), policy[block]
        assert row[2] == str(x["came"][j])
        number_of, _, _ = rate(x["lost_rate"][j], x["lost_ci"][j]).partition(" ")
        assert row[3].startswith(number_of), "the interval may take a line of its own"
        assert row[-1] == number(x["angle_err_rms_deg"][j], 2)


def test_worst_cases_of_every_policy_but_bounds(results: Results) -> None:
    table = worst_table(results, 2)
    assert table is not None
    text = text_of(table)
    assert max(map(len, text.splitlines())) <= 80
    listed: list[dict[str, Any]] = results.policies["smo"]["worst"]
    assert all(case["scenario"] in text for case in listed[:2])
    assert cells(text, "smo")[1] == listed[0]["scenario"]
    assert "sensored" not in text
    assert "[s]" in text, "a unit, not a style of rich"
    bounds = {name: x for name, x in results.policies.items() if x["bound"]}
    assert bounds and worst_table(replace(results, policies=bounds), 2) is None


def test_pairs_are_differences_to_the_first(results: Results) -> None:
    text = text_of(paired_table(results))
    assert "difference to eq25" in text
    assert cells(text, "smo")[1] == number(100.0 * results.paired["smo"]["lost_rate"], 1)
    assert cells(text, results.note("smo"))[0] == "(smo)", "another drive than the first one's"
    there = results.paired["smo"]["there"]["lost_rate"]
    text = text.split("│ smo")[1].split("│ sensored")[0]
    assert share(results.paired["smo"]["lost_rate"], there) in text


def test_the_hand_over_has_a_table_of_its_own(results: Results) -> None:
    means, pairs = text_of(results.table(HANDOVER_COLUMNS)), results.paired["smo"]
    assert max(map(len, means.splitlines())) <= 80
    ripple = results.policies["eq25"]["torque_ripple_window"]
    assert cells(means, "eq25")[1].startswith(number(100.0 * ripple, 2))
    row = cells(text_of(paired_table(results, HANDOVER_COLUMNS)), "smo")
    assert row[1] == number(100.0 * pairs["torque_ripple_window"], 2)

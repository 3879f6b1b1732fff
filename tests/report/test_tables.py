"""Cells and sentences of a report, from results that are written by hand."""

from typing import Any

from sensorless.evaluation.results import Results
from sensorless.machine.motor import Motor
from sensorless.report.tables import COLUMNS, held, pair_rows, said


def of(policies: dict[str, dict[str, Any]], paired: dict[str, dict[str, Any]]) -> Results:
    return Results("stress-1", 1, 9, "paper", "", {}, {}, policies, paired)


def test_the_first_policy_is_told_beside_the_other() -> None:
    """Results have the other minus the first: 0.05, of 1, so 4.8 % of what the other has."""
    pair: dict[str, Any] = {"survived_both": 9, "there": {}}
    for key, *_ in COLUMNS:
        pair[key], pair["there"][key] = 0.05, 1.0
        pair[f"{key}_ci"] = (0.03, 0.07)
    who = {"bound": False, "own": {}}
    (row,) = pair_rows(of({"mine": who, "eq25": who}, {"eq25": pair}), ["mine", "eq25"])
    deviation = row["cells"][[key for key, *_ in COLUMNS].index("torque_dev_rms")]
    assert deviation == {
        "text": "−5.00",
        "interval": "−7.00 … −3.00",
        "value": "-5",
        "word": "better",
        "share": "−5 %",
    }


def test_a_policy_fails_where_the_largest_share_is_lost() -> None:
    """Three of a hundred are more drives, and fewer of those that came."""
    quadrants = {"place": ["a", "b"], "lost": [3, 2], "came": [100, 4], "torque_dev_rms": [0.1] * 2}
    speeds = {"from_rated_speed": [0.0], "lost": [0], "came": [9], "torque_dev_rms": [0.1]}
    results = of({"mine": {"by_quadrant": quadrants, "by_speed": speeds}}, {})
    assert said(results, "mine") == "stress-1: it loses most at b, 2 of 4 that came there."


def test_the_envelope_names_the_speeds_and_loads_that_are_lost(motor: Motor) -> None:
    """Rows of a grid of 3 x 3 are speeds, columns loads; the second point is without load.

    Of the last the machine itself is not capable, whatever else was found there.
    """
    causes = [None, "angle", *[None] * 6, "angle+twin"]
    points = {"lost": [i == 1 for i in range(9)], "lost_cause": causes}
    told = held(of({"mine": {"scenarios": points}}, {}), motor)
    assert told == (
        "Over speed and load: mine keeps lock in 7 of 8 points, and loses the others between "
        "−1500 and −1500 r/min, 0.0 and 0.0 N m."
    )

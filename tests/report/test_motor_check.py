"""What the quick run of a machine's check adds to the verdict."""

import math

import pytest

from sensorless.report.motor_check import QuickRun, judged
from sensorless.suitability.finding import LIMIT, NO


@pytest.mark.parametrize(
    ("lost", "infeasible", "weights", "said"),
    [
        (0.0, 0.0, [], ""),
        (0.1, 0.0, [LIMIT], "loses 10%"),
        (0.6, 0.0, [NO], "loses 60%"),
        (0.1, 0.2, [LIMIT, LIMIT], "fails 20%"),
        (math.nan, 1.0, [NO], "fails all"),
    ],
)
def test_what_the_quick_run_finds(
    lost: float, infeasible: float, weights: list[str], said: str
) -> None:
    found = judged(QuickRun(100, lost, infeasible, 0.01))
    assert [finding.weight for finding in found] == weights
    texts = " ".join(finding.text for finding in found)
    assert said in texts and "nan" not in texts

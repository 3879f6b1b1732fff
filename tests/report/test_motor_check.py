"""What the quick run of a machine's check adds to the verdict."""

import math

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.report.motor_check import LOST, QuickRun, check, judged
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


def test_trips_ask_for_a_shorter_period() -> None:
    """A machine of 21 PWM periods a turn with too high an L_q: by the current limit."""
    coarse = member(7207, 29)
    run = check(coarse, DriveDesign(coupled_L_q_bias=1.2), 16).run
    assert run is not None and run.lost > LOST[0] and run.tripped == 1.0
    assert "shorter T_s" in judged(run)[-1].text
    assert "T_s" not in judged(QuickRun(100, 0.1, 0.0, 0.01, 0.2))[0].text

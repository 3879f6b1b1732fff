"""One home for the time between two decisions."""

import pytest

from sensorless.agents.train.config import TrainConfig
from sensorless.decision import RUNNING, TRAINING, decision_periods, decision_time, whole_periods
from sensorless.envs.blend_settings import BlendSettings
from sensorless.machine.motor import Motor


def test_defaults_come_from_there() -> None:
    assert BlendSettings().decision_period == RUNNING
    assert TrainConfig().decision_ms == pytest.approx(1e3 * TRAINING)


@pytest.mark.parametrize(
    ("motor", "periods"), [("paper", 5), ("ipmsm_2200w", 5), ("pmsyrm_5600w", 10)]
)
def test_a_decision_is_whole_periods(motor: str, periods: int) -> None:
    machine = Motor.load(motor)
    assert decision_periods(machine) == periods
    assert decision_time(machine) == pytest.approx(RUNNING)
    assert whole_periods(0.0, machine) == 1

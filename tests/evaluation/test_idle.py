"""The swing of a drive without load, and what a machine's check says of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import lib
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation import idle as module
from sensorless.evaluation.idle import SPEEDS, idle_swing
from sensorless.evaluation.machine_check import IDLE, swings_idle
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.suitability.finding import LIMIT, NOTE


def test_dead_time_makes_it() -> None:
    motor = Motor.load("brusa_hsm1")
    for_motor = {x: replace(motor, dead_time=x * motor.dead_time) for x in (0.1, 1.0)}
    swing = {x: idle_swing(m, DriveDesign(), make_policy("eq25", m)) for x, m in for_motor.items()}
    assert 0.0 < 3.0 * swing[0.1][0] < swing[1.0][0] < 0.1
    assert all(speed in SPEEDS for _, speed in swing.values())


def test_it_is_on_the_switching_inverter_whatever_the_design(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where dead time acts; all else is as the design has it."""
    built: list[SimFactory] = []

    def factory(motor: Motor, design: DriveDesign) -> SimFactory:
        built.append(SimFactory(motor, design))
        return built[-1]

    monkeypatch.setattr(module, "SimFactory", factory)
    monkeypatch.setattr(module, "DURATION", 1.0)
    motor, design = Motor.load("paper"), DriveDesign(estimator="smo", carrier=False)
    idle_swing(motor, design, make_policy("eq25", motor))
    assert [made.design for made in built] == [replace(design, carrier=True)]


@pytest.mark.parametrize(
    ("swing", "weight", "said"),
    [
        (IDLE[0] + 1e-3, NOTE, "without load at 50% of rated speed the torque swings by 2.1%"),
        (IDLE[1] + 1e-3, LIMIT, "swings by 5.1% of rated"),
        (math.nan, LIMIT, "the drive under Eq. 25 is lost without load at 50% of rated speed"),
    ],
)
def test_a_swing_is_told(swing: float, weight: str, said: str) -> None:
    (found,) = swings_idle(swing, 0.5, "Eq. 25")
    assert found.weight == weight and said in found.text


def test_a_quiet_drive_is_not_told() -> None:
    assert swings_idle(IDLE[0], 0.5, "Eq. 25") == []


@pytest.mark.parametrize(("twin", "told"), [(0, True), (int(lib.LOST_TWIN), False)])
def test_a_drive_is_not_blamed_for_what_an_encoder_cannot_do(
    monkeypatch: pytest.MonkeyPatch, twin: int, told: bool
) -> None:
    lost = np.array([0, 0, int(lib.LOST_ANGLE) | twin, 0, 0, 0], dtype=np.int32)
    path = "sensorless.evaluation.idle.rollout"
    monkeypatch.setattr(path, lambda *of: replace(rollout(*of), lost=lost))
    motor = Motor.load("paper")
    swing, _ = idle_swing(motor, DriveDesign(), make_policy("eq25", motor))
    assert math.isnan(swing) == told

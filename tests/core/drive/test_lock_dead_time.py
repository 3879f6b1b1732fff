"""Inverter voltage that the drive cannot know is no lost lock."""

import numpy as np
import pytest

from sensorless.design import records
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor
from sensorless.observers import lock_design
from sensorless.policies.registry import make_policy

ROWS = (117, 233, 872, 1259, 2093, 2104, 3563, 3991)
"""Of 4000: half a dead time more than the file's, little current as the shaft begins to turn."""


def alarms() -> int:
    """False alarms of ``brusa_hsm1``, whose dead time takes 13 % of its rated EMF."""
    motor = Motor.load("brusa_hsm1")
    drawn = SuiteRows("stress", motor, 90001, 4000).draw()[np.array(ROWS)]
    s = score(make_policy("eq25", motor), drawn, SimFactory(motor, DriveDesign()))
    assert not s.lost.any()
    return int(s.lock["false_alarms"].sum())


def test_leaving_standstill_with_much_dead_time_is_no_alarm() -> None:
    assert alarms() == 0


def test_it_was_where_less_voltage_had_a_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lock_design, "E_LEAST", 0.62)
    monkeypatch.setattr(lock_design, "threshold_voltage", lambda _: 0.0)
    monkeypatch.setattr(records, "designed", records.designed.__wrapped__)
    assert alarms() == len(ROWS)

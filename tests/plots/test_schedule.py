"""Pictures of tables."""

from sensorless.baselines.linear import linear_table
from sensorless.machine.motor import Motor
from sensorless.plots.schedule import schedule_maps


def test_tables_of_one_axis_are_drawn() -> None:
    table = linear_table(0.2, 0.3)
    assert len(schedule_maps("eq25", table, table, Motor.load("paper")).axes) == 3

"""Numbers for the schedule alone, in a drive with its own observers."""

import re

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.export.faults import fault_tables
from sensorless.export.hook import hook_source, hook_text
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable


def test_a_full_number_is_twice_the_rated_quantity(
    motor: Motor, table: KsTable, design: DriveDesign
) -> None:
    """1500 r/min of 2 pole pairs are 314.16 rad/s; the plausible most are those of the guard."""
    drive = control_record(motor, design)
    text = hook_source(motor, drive, table, 5)
    found = {name: float(value) for name, value in re.findall(r"\.(\w+) = ([-+.\de]+)f,", text)}
    assert found["omega_full"] == pytest.approx(200.0 * np.pi, rel=1e-6)
    assert found["i_full"] == pytest.approx(2.0 * motor.i_rated, rel=1e-6)
    assert found["omega_most"] == pytest.approx(float(drive["guard"]["omega"]), rel=1e-6)
    assert found["i_most"] == pytest.approx(float(drive["guard"]["i_sample"]), rel=1e-6)
    assert found["omega_most"] > found["omega_full"] / 2.0


@pytest.mark.parametrize(("signal", "refused"), [("torque_current", False), ("emf", True)])
def test_a_table_over_another_signal_is_said_to_be_refused(signal: str, refused: bool) -> None:
    axes = (Axis("speed", 0.0, 1.0, 2), Axis(signal, 0.0, 1.0, 2))
    said = hook_text(KsTable(axes, np.zeros((2, 2), np.float32)))
    assert (f"also reads {signal}," in said) == refused
    assert ("`make example`" in said) != refused


def test_a_drive_that_cannot_find_its_pole_is_told_to_stop() -> None:
    """A state that is begun anew is on a guessed pole there."""
    guesses, finds = (fault_tables(finds=x)["drive"] for x in (False, True))
    assert "on a guessed pole" in guesses and "on a guessed pole" not in finds
    assert "let it start anew" in finds and "let it start anew" not in guesses

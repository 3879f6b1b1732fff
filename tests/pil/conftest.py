"""Processor in the loop, run once."""

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.pil.pil import Report, pil
from sensorless.table.ks_table import KsTable


@pytest.fixture(scope="session")
def report(target: None, table: KsTable, motor: Motor, design: DriveDesign) -> Report:
    return pil(table, motor, design, policy="trial")

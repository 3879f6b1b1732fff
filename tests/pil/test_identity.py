"""The same bits from every compiler and level; long: ``benchmarks/bit_identity.py``."""

import shutil

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.pil.identity import ALL, LEVELS, Configuration, identity
from sensorless.table.ks_table import KsTable

PERIODS = 6000


@pytest.mark.parametrize("level", [level for level in LEVELS if level != "-O2"])
@pytest.mark.usefixtures("target")
def test_target_at_every_level(level: str, table: KsTable, motor: Motor) -> None:
    chosen = [Configuration("target", level)]
    (found,) = identity(table, motor, DriveDesign(), PERIODS, chosen, drives=16)
    assert found.periods >= PERIODS and found.mismatches == 0


@pytest.mark.parametrize("chosen", [c for c in ALL if c.machine == "host"], ids=str)
def test_host_at_every_level(chosen: Configuration, table: KsTable, motor: Motor) -> None:
    if shutil.which(chosen.compiler) is None or shutil.which("make") is None:
        pytest.skip(f"needs {chosen.compiler} and make")
    (found,) = identity(table, motor, DriveDesign(), PERIODS, [chosen], drives=16)
    assert found.periods >= PERIODS and found.mismatches == 0


def test_the_comparison_can_fail(table: KsTable, motor: Motor) -> None:
    """Fast arithmetic on the device, which changes last bits, is noticed."""
    if shutil.which("gcc") is None or shutil.which("make") is None:
        pytest.skip("needs gcc and make")
    chosen = [Configuration("host", "-O2 -ffast-math")]
    (found,) = identity(table, motor, DriveDesign(), PERIODS, chosen, drives=16)
    assert found.mismatches > 0

"""The same bits from every compiler and level, in a short run."""

import shutil

import pytest

from benchmarks.bit_identity import ALL, Configuration, Outcome, identity
from sensorless.design.drive import DriveDesign
from sensorless.export import selftest
from sensorless.machine.motor import Motor
from sensorless.pil.tools import missing_packages
from sensorless.table.ks_table import KsTable

PERIODS = 3200

TARGET = [c for c in ALL if c.machine == "target" and c.level != "-O2"]
HOST = [c for c in ALL if c.machine == "host"]
FAST = Configuration("host", "-O2 -funsafe-math-optimizations")

Found = dict[Configuration, Outcome]


@pytest.fixture(scope="module")
def found(table: KsTable, motor: Motor, design: DriveDesign) -> Found:
    """Outcome of every configuration whose tools are here, from one export."""
    if shutil.which("make") is None:
        pytest.skip("needs make")
    chosen = [*HOST, FAST, *(() if missing_packages() else TARGET)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selftest, "find_compiler", lambda: None)
        outcomes = list(identity(table, motor, design, PERIODS, chosen, drives=16))
    return {o.configuration: o for o in outcomes}


@pytest.mark.parametrize("chosen", TARGET, ids=lambda c: c.level)
@pytest.mark.usefixtures("target")
def test_target_at_every_level(chosen: Configuration, found: Found) -> None:
    assert found[chosen].periods >= PERIODS and found[chosen].mismatches == 0


@pytest.mark.parametrize("chosen", HOST, ids=str)
def test_host_at_every_level(chosen: Configuration, found: Found) -> None:
    if shutil.which(chosen.compiler) is None:
        pytest.skip(f"needs {chosen.compiler}")
    assert found[chosen].periods >= PERIODS and found[chosen].mismatches == 0


def test_the_comparison_can_fail(found: Found) -> None:
    """Unsafe arithmetic on the device, which changes last bits, is noticed."""
    if shutil.which(FAST.compiler) is None:
        pytest.skip(f"needs {FAST.compiler}")
    assert found[FAST].mismatches > 0

"""Processor in the loop, run once; skipped without cross compiler or emulator, but not in CI."""

import os

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.pil.pil import Report, pil
from sensorless.pil.tools import missing_packages
from sensorless.table.ks_table import Axis, KsTable


@pytest.fixture(scope="session")
def target() -> None:
    """Cross compiler and emulator are there; required where the environment says CI=true."""
    missing = missing_packages()
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI needs {', '.join(missing)}")
    if missing:
        pytest.skip(f"needs the Debian packages {', '.join(missing)}")


@pytest.fixture(scope="session")
def motor() -> Motor:
    return Motor.load("paper")


@pytest.fixture(scope="session")
def table() -> KsTable:
    """Eq. 25 with bumps over the torque current: both axes matter."""
    axes = (Axis("speed", 0.0, 0.5, 9), Axis("torque_current", -1.5, 1.5, 5))
    ramp = np.clip((0.27 - axes[0].nodes[:, None]) / 0.07, 0.0, 1.0)
    bumps = 0.1 * np.random.default_rng(5).standard_normal((9, 5))
    values = np.clip(ramp + np.where((ramp > 0) & (ramp < 1), bumps, 0.0), 0.0, 1.0)
    return KsTable(axes, values.astype(np.float32))


@pytest.fixture(scope="session")
def report(target: None, table: KsTable, motor: Motor) -> Report:
    return pil(table, motor, DriveDesign(), policy="trial")

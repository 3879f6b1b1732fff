"""An export of a table with two axes, made once; fixtures of the export's tests."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.export.export import Exported, export
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable


@pytest.fixture(scope="session")
def motor() -> Motor:
    return Motor.load("paper")


@pytest.fixture(scope="session")
def design() -> DriveDesign:
    return DriveDesign()


@pytest.fixture(scope="session")
def table() -> KsTable:
    """Eq. 25 with bumps: a table that uses both of its axes."""
    axes = (Axis("speed", 0.0, 0.5, 9), Axis("torque_current", -1.5, 1.5, 5))
    ramp = np.clip((0.27 - axes[0].nodes[:, None]) / 0.07, 0.0, 1.0)
    bumps = 0.1 * np.random.default_rng(5).standard_normal((9, 5))
    values = np.clip(ramp + np.where((ramp > 0) & (ramp < 1), bumps, 0.0), 0.0, 1.0)
    return KsTable(axes, values.astype(np.float32), provenance={"command": "train --seed 5"})


@pytest.fixture(scope="session")
def exported(
    tmp_path_factory: pytest.TempPathFactory, table: KsTable, motor: Motor, design: DriveDesign
) -> Exported:
    folder = tmp_path_factory.mktemp("export") / "made" / "here"
    return export(table, motor, design, folder, policy="trial")


@pytest.fixture
def copied(exported: Exported, tmp_path: Path) -> Path:
    """Return a copy of the exported folder that a test may change."""
    return shutil.copytree(exported.folder, tmp_path / "copy")

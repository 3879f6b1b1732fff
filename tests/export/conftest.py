"""What the tests of the export share."""

import shutil
from pathlib import Path

import pytest

from sensorless.export.export import Exported


@pytest.fixture
def copied(exported: Exported, tmp_path: Path) -> Path:
    """Return a copy of the exported folder that a test may change."""
    return shutil.copytree(exported.folder, tmp_path / "copy")

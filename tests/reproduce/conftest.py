"""The reproduction of the source paper, run once."""

import json
from pathlib import Path
from typing import Any

import pytest

from sensorless.reproduce.reproduce import reproduce


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    assert all(path.is_file() for path in reproduce(folder))
    return folder


@pytest.fixture(scope="session")
def data(folder: Path) -> dict[str, Any]:
    """What the page says, as JSON types."""
    return dict(json.loads((folder / "paper.json").read_text(encoding="utf-8")))

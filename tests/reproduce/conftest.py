"""The reproduction of the source paper, run once."""

import json
from pathlib import Path
from typing import Any

import pytest

from sensorless.machine.motor import Motor
from sensorless.reproduce import steady, switching
from sensorless.reproduce.case import Case
from sensorless.reproduce.reproduce import cases, write


@pytest.fixture(scope="session")
def done(motor: Motor) -> list[Case]:
    """All cases; those with the noise of real sensors are means of 6 runs instead of 16.

    A constant speed is held for 1.5 s instead of 2.5, of which the last one counts.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(switching, "REPEATS", 6)
        patch.setattr(steady, "HELD", 1.5)
        return cases(motor)


@pytest.fixture(scope="session")
def folder(done: list[Case], motor: Motor, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    assert all(path.is_file() for path in write(done, motor, folder))
    return folder


@pytest.fixture(scope="session")
def data(folder: Path) -> dict[str, Any]:
    """What the page says, as JSON types."""
    return dict(json.loads((folder / "paper.json").read_text(encoding="utf-8")))

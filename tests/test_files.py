"""Files that can or cannot be written."""

from pathlib import Path

import pytest

from sensorless.errors import UserError
from sensorless.files import check_writable


@pytest.mark.parametrize("name", ["missing/results.json", "file/results.json", "folder"])
def test_places_that_cannot_be_written_are_found_out(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    with pytest.raises(UserError, match="out: ") as caught:
        check_writable(tmp_path / name)
    assert name in str(caught.value) and "\n" not in str(caught.value)


def test_a_folder_without_the_right_to_write_is_found_out() -> None:
    with pytest.raises(UserError, match="out: "):
        check_writable(Path("/proc/results.json"))


def test_the_check_leaves_nothing_behind(tmp_path: Path) -> None:
    check_writable(tmp_path / "results.json")
    assert not list(tmp_path.iterdir())


def test_no_file_asked_for_is_no_mistake() -> None:
    check_writable(None)

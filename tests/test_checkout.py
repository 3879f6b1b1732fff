"""A checkout without symbolic links says so before it builds anything."""

import runpy
import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_a_checkout_without_links_stops_with_one_line(tmp_path: Path) -> None:
    shutil.copy(ROOT / "setup.py", tmp_path)
    (tmp_path / "sensorless").mkdir()
    links = [path for path in (ROOT / "sensorless").iterdir() if path.is_symlink()]
    assert len(links) == 7
    for link in links:  # as git writes them with core.symlinks=false
        (tmp_path / "sensorless" / link.name).write_text(str(link.readlink()))
    with pytest.raises(SystemExit, match=r"symbolic links.*core.symlinks=true") as stopped:
        runpy.run_path(str(tmp_path / "setup.py"))
    assert "\n" not in str(stopped.value)

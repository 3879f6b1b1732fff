"""What a checkout is built into, and that one without symbolic links says so before that."""

import re
import runpy
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest
import setuptools

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


def test_the_wheel_is_tagged_as_its_module_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """One module for the oldest Python that the project allows and for every later one."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "path", sys.path.copy())  # core/binding.py adds to it
    said: dict[str, Any] = {}
    monkeypatch.setattr(setuptools, "setup", lambda **given: said.update(given))
    runpy.run_path("setup.py")
    build = setuptools.Distribution(said)
    command = build.get_command_obj("bdist_wheel")
    command.ensure_finalized()
    (module,) = build.ext_modules
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    (oldest,) = re.findall(r'^requires-python = ">=3\.(\d+)"$', project, flags=re.MULTILINE)
    assert module.py_limited_api
    assert command.get_tag()[:2] == (f"cp3{oldest}", "abi3")

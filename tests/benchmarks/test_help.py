"""Every script explains itself, whatever is installed beside it."""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LIGHT = ("peer_gem", "peer_motulator", "bit_identity", "peers")
"""Scripts that start quickly; the others take the same parser."""


@pytest.mark.parametrize("name", LIGHT)
def test_help(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", [name, "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(ROOT / "benchmarks" / f"{name}.py"), run_name="__main__")
    said = capsys.readouterr()
    assert not ended.value.code and not said.err
    assert said.out.startswith("usage: ")


@pytest.mark.parametrize("folder", ["benchmarks", "studies", "web"])
def test_every_script_with_a_command_line_parses_it(folder: str) -> None:
    for path in (ROOT / folder).glob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "__main__" in text:
            assert "ArgumentParser(" in text or "parser(__doc__)" in text, path.name
            assert "sys.argv[1" not in text, path.name

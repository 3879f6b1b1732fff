"""A file that never ends, or is larger than any that is read, is one line."""

import sys
from pathlib import Path

import pytest

from sensorless import files
from tests.helpers.command import run

ENDLESS = [
    ("replay", "/dev/zero"),
    ("motor", "import-map", "/dev/zero", "--motor", "paper", "--out", "x.toml"),
    ("identify", "machine", "--log", "/dev/zero", "--motor", "paper", "--out", "x.toml"),
    ("identify", "bring-up", "--log", "/dev/zero", "--motor", "paper"),
    ("simulate", "--plant", "/dev/zero", "--inputs", "in.csv", "--out", "out.csv"),
    ("evaluate", "--policy", "tuned:/dev/zero"),
]


@pytest.mark.skipif(sys.platform == "win32", reason="no such file there")
@pytest.mark.parametrize("words", ENDLESS, ids=lambda words: " ".join(words[:2]))
def test_an_endless_file_is_refused_in_one_line(words: tuple[str, ...], tmp_path: Path) -> None:
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("error: "), done.stderr
    assert "/dev/zero" in done.stderr and "more than 512 MiB" in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_file_of_the_largest_size_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "x"
    path.write_bytes(bytes(9))
    monkeypatch.setattr(files, "MOST_BYTES", 9)
    assert files.read_bytes(path) == bytes(9)
    monkeypatch.setattr(files, "MOST_BYTES", 8)
    with pytest.raises(OSError, match="more than 0 MiB"):
        files.read_bytes(path)

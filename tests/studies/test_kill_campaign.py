"""What a kill leaves is whole or hidden, and the campaign would see it if it were not."""

import os
import random
import signal
import time
from itertools import count
from pathlib import Path

from sensorless.files import put, write_atomic
from tests.helpers.script import script

STUDY = script("studies/kill_campaign.py")
KILLS = 8


def write_for_ever(folder: Path) -> None:
    """Replace a file and a folder, again and again."""
    for i in count():
        write_atomic(folder / "numbers.csv", "a,b\n" + f"{i},{i}\n" * 2000)
        part = folder / f".made.{os.getpid()}.part"
        part.mkdir()
        (part / "a.json").write_text(f"[{i}]")
        put(part, folder / "made")
        for path in part.iterdir() if part.exists() else ():
            path.unlink()
        if part.exists():
            part.rmdir()


def test_whatever_the_time_of_the_kill_all_that_shows_is_whole(tmp_path: Path) -> None:
    draw = random.Random(1)
    for _ in range(KILLS):
        child = os.fork()
        if child == 0:
            write_for_ever(tmp_path)
        time.sleep(0.01 + 0.02 * draw.random())
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        assert list(STUDY.broken(tmp_path)) == []
    assert (tmp_path / "numbers.csv").is_file() and (tmp_path / "made" / "a.json").is_file()


def test_the_campaign_sees_half_a_file(tmp_path: Path) -> None:
    halves = {
        "a.json": "{", "b.csv": "a,b\n1", "c.zip": "PK", "d.png": "\x89PNG", "e.html": "<html>",
        "SHA256SUMS": "0" * 64 + "  a.json\n",
    }  # fmt: skip
    for name, text in halves.items():
        (tmp_path / name).write_text(text)
    (tmp_path / f".f.json.{2**22 + 1}.part").write_text("{")
    assert [text.split(":")[0] for text in STUDY.broken(tmp_path)] == sorted(halves)

"""Files that can or cannot be written."""

import ctypes
import errno
import os
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless import files
from sensorless.cli.app import app
from sensorless.errors import UserError
from sensorless.files import check_folder, check_writable, put, write_atomic, write_record


@pytest.mark.parametrize(
    "words",
    [
        "certify eq25 --size 10 --out deep.json",
        "simulate --scenario deep.json:0",
        "simulate --plant deep.json --inputs deep.json --out o.csv",
        "report eq25 --out rep --size 2 --grid 2 --policy smo --suite stress-1",
        "export eq25 --out exp --no-fit",
    ],
)
def test_json_that_is_nested_too_deeply_is_refused(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("deep.json", "rep/results-stress-1.json", "exp/ks_table.json"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("[" * 100_000 + "]" * 100_000)
    done = CliRunner().invoke(app, words.split())
    assert isinstance(done.exception, UserError), done.exception
    assert "\n" not in str(done.exception)


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
    check_folder(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())


def test_no_file_asked_for_is_no_mistake() -> None:
    check_writable(None)


def left_by(process: int, folder: Path, age: float = 3600.0) -> Path:
    """What a process that was killed an hour ago left half-written."""
    path = folder / f".results.json.{process}.part"
    path.write_text("{")
    past = time.time() - age
    os.utime(path, (past, past))
    return path


GONE = 2**22 + 1
"""No process has this number."""


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    left = [
        left_by(GONE, tmp_path),
        left_by(GONE, tmp_path, age=0.0),
        left_by(os.getppid(), tmp_path),
    ]
    write_atomic(tmp_path / "other.json", "{}")
    assert all(path.exists() for path in left), "another file's"
    left_by(GONE, tmp_path)
    write_atomic(tmp_path / "results.json", "{}")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f".results.json.{os.getppid()}.part", "other.json", "results.json",
    ]  # fmt: skip


def test_a_failed_write_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "results.json"
    write_atomic(path, "old")

    def full(self: Path, data: bytes) -> int:
        with self.open("wb") as file:
            file.write(data[:3])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(UserError, match="No space left on device"):
        write_atomic(path, "newer")
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_bytes_are_on_the_disk_before_the_name_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    replace = os.replace
    monkeypatch.setattr(files, "sync", lambda path: order.append(f"sync {path.name}"))

    def renamed(a: Path, b: Path) -> None:
        order.append("rename")
        replace(a, b)

    monkeypatch.setattr(os, "replace", renamed)
    write_atomic(tmp_path / "a.json", "{}")
    assert order == [f"sync .a.json.{os.getpid()}.part", "rename", f"sync {tmp_path.name}"]


@pytest.mark.parametrize("system", ["", "without a swap"])
def test_a_folder_takes_the_place_of_another(
    tmp_path: Path, system: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if system:
        monkeypatch.setattr(ctypes, "CDLL", lambda name: None)
    for name in ("old", "new"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").write_text(name)
    put(tmp_path / "new", tmp_path / "old")
    assert (tmp_path / "old" / "file").read_text() == "new"
    assert (tmp_path / "new" / "file").read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new", "old"]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    """What it points to is written, whole or not at all, and may be new."""
    (tmp_path / "data").mkdir()
    link = tmp_path / "latest.json"
    link.symlink_to("data/a.json")
    for text in ("new", "newer"):
        check_writable(link)
        write_atomic(link, text)
        assert link.is_symlink() and (tmp_path / "data" / "a.json").read_text() == text
    (tmp_path / "lost.json").symlink_to("nowhere/a.json")
    with pytest.raises(UserError, match=r"lost\.json'.*; write to another folder"):
        check_writable(tmp_path / "lost.json")
    assert sorted(path.name for path in tmp_path.rglob("*")) == [
        "a.json", "data", "latest.json", "lost.json",
    ]  # fmt: skip


def test_a_device_is_written_to_and_not_replaced() -> None:
    check_writable(Path("/dev/null"))
    write_atomic("/dev/null", "text")
    assert Path("/dev/null").is_char_device()
    assert not list(Path("/dev").glob(".null.*"))


def test_a_name_too_long_is_one_line(tmp_path: Path) -> None:
    for name in ("n" * 300, "n" * 250):
        with pytest.raises(UserError, match="too long"):
            check_writable(tmp_path / name)
        with pytest.raises(UserError, match="too long"):
            write_atomic(tmp_path / name, "")


def test_text_from_a_shell_without_unicode_is_written(tmp_path: Path) -> None:
    write_atomic(tmp_path / "a.txt", "bad\udcff.csv")
    assert (tmp_path / "a.txt").read_text() == "bad\\udcff.csv"


def test_a_record_has_floats_of_six_digits(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    write_record(path, {"share": np.float32(1.0) / 3.0, "n": 1234567, "rows": [1e-9 / 7.0]})
    assert path.read_text() == '{"share":0.333333,"n":1234567,"rows":[1.42857e-10]}\n'


def test_what_is_write_protected_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Renaming another file or folder over it would not ask."""
    file, folder, new = tmp_path / "a.json", tmp_path / "a", tmp_path / "b"
    file.write_text("old")
    folder.mkdir()
    new.mkdir()
    monkeypatch.setattr(os, "access", lambda path, mode: path == tmp_path)  # also for root
    with pytest.raises(UserError, match=r"^out: .*a\.json': it is write-protected"):
        check_writable(file)
    with pytest.raises(UserError, match=r"a\.json': it is write-protected"):
        write_atomic(file, "new")
    with pytest.raises(OSError, match="write-protected"):
        put(new, folder)
    assert file.read_text() == "old" and new.is_dir()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "a.json", "b"]

"""Output that lacks a sign is spelled, its tables stay in line; signals end the program."""

import io
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rich.table import Table

from sensorless.cli.surroundings import (
    NARROWEST,
    AnyConsole,
    Signalled,
    ended_by_signals,
    never_fail_to_print,
    spelled,
)
from tests.helpers.command import process


def ascii_file() -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(), encoding="ascii")


def printed(file: io.TextIOWrapper) -> list[str]:
    file.flush()
    buffer = file.buffer
    assert isinstance(buffer, io.BytesIO)
    return buffer.getvalue().decode("ascii").splitlines()


def test_signs_have_names() -> None:
    assert spelled("−3 °/A ± 1 · é 漢") == "-3 deg/A +- 1 * e ?"


def test_tables_stay_in_line() -> None:
    file = ascii_file()
    table = Table("RMS [°]", "θm/2 − x")
    table.add_row("1", "0.5 ± 0.1 [°]")
    AnyConsole(file=file, width=60).print(table)
    lines = printed(file)
    assert "RMS [deg]" in lines[1] and "thetam/2 - x" in lines[1] and "[deg]" in lines[3]
    assert len({len(line) for line in lines}) == 1


def test_a_console_with_unicode_keeps_its_signs() -> None:
    file = io.StringIO()
    AnyConsole(file=file, width=60).print("1 °", highlight=False)
    assert file.getvalue() == "1 °\n"


def test_text_is_printed_as_it_is() -> None:
    file, odd = io.StringIO(), "b[red][/x]/:x: [s]"
    table = Table(odd, title=odd)
    table.add_row(odd)
    console = AnyConsole(file=file, width=60)
    console.print(odd, highlight=False)
    console.print(table)
    assert file.getvalue().count(odd) == 4


def test_what_is_printed_otherwise_is_spelled_too(monkeypatch: pytest.MonkeyPatch) -> None:
    file = ascii_file()
    monkeypatch.setattr(sys, "stdout", file)
    never_fail_to_print()
    print("−3 ° bad\udcff")
    assert printed(file) == ["-3 deg bad?"]


@pytest.mark.skipif(shutil.which("sh") is None, reason="no shell")
@pytest.mark.parametrize(
    ("words", "closed", "status", "said"),
    [
        ("settings", "2>&-", 0, "speed_hz"),
        ("--version", "0<&- 2>&-", 0, "sensorless "),
        ("simulate --duration 0.01 --out run.csv", "2>&-", 0, "kept lock"),
        ("motor new --name a --out a.toml", "0<&-", 2, "error: poles: missing"),
        ("settings", "1>&-", 0, ""),
    ],
)
def test_closed_streams(words: str, closed: str, status: int, said: str, tmp_path: Path) -> None:
    """As a parent that is a service may leave them."""
    line = f"'{sys.executable}' -m sensorless {words} {closed}"
    done = subprocess.run(
        ["sh", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == status and said in done.stdout + done.stderr
    run = tmp_path / "run.csv"
    assert not run.exists() or run.read_text(encoding="utf-8").startswith("t,omega_m_ref")


@pytest.mark.parametrize("columns", ["0", "00", "²", "99999999999999999999"])
@pytest.mark.parametrize("words", ["motors", "motors --help"])
def test_a_width_that_no_terminal_has(
    columns: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    wanted = process(*words.split(), cwd=tmp_path).stdout
    monkeypatch.setenv("COLUMNS", columns)
    done = process(*words.split(), cwd=tmp_path)
    assert done.returncode == 0 and done.stdout == wanted and wanted.strip()


def test_a_width_that_a_terminal_has(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "132")
    assert AnyConsole(file=io.StringIO()).width == 132


def test_a_narrow_terminal_keeps_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "20")
    assert AnyConsole(file=io.StringIO()).width == NARROWEST


class Dies:
    """Something that a signal meets on its way out."""

    def __del__(self) -> None:
        signal.raise_signal(signal.SIGTERM)


def test_a_signal_that_a_destructor_swallows_comes_again() -> None:
    with pytest.raises(Signalled), ended_by_signals() as came:
        Dies()
        time.sleep(10.0)
    assert came == [signal.SIGTERM] * 2
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL

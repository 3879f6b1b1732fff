"""Output that lacks a sign is spelled, and its tables stay in line."""

import io
import sys

import pytest
from rich.table import Table

from sensorless.cli.surroundings import AnyConsole, never_fail_to_print, spelled


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

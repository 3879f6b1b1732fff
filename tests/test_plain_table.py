"""Texts of a table are shown as they are, on any console."""

import io

from rich.console import Console

from sensorless.plain_table import PlainTable


def test_brackets_are_no_markup() -> None:
    file, odd = io.StringIO(), "b[red][/x] [s]"
    table = PlainTable(odd, title=odd)
    table.add_row(odd)
    Console(file=file, width=60).print(table)
    lines = file.getvalue().splitlines()
    assert file.getvalue().count(odd) == 3
    assert {len(line) for line in lines[1:]} == {len(odd) + 4}

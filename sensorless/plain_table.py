"""A table for any terminal or notebook whose texts are shown as they are."""

from typing import Any

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text


class PlainTable(Table):
    """A table without markup: a unit like [s], or a name with brackets, is no style of rich."""

    def __init__(self, *headers: str, title: str | None = None, **how: Any) -> None:
        shown = None if title is None else Text(title, "table.title")
        super().__init__(*headers, title=shown, **how)

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render it with cells as they are."""
        yield from super().__rich_console__(console, options.update(markup=False))

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        """Return the widths of the same."""
        return super().__rich_measure__(console, options.update(markup=False))

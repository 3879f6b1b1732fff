"""Writes waveforms as a picture or as a page, whichever the file's name asks for."""

from collections.abc import Sequence
from pathlib import Path

from sensorless.files import write_atomic
from sensorless.plots.figure import check_picture, save
from sensorless.plots.wave import FOLDED, Wave
from sensorless.plots.waveforms import waveforms
from sensorless.report.waves import packed

PAGES = (".html", ".htm")


def check_drawable(path: Path | None) -> None:
    """Check before any work that ``write_waves`` can draw; errors as in ``check_picture``."""
    check_picture(path, PAGES)


def write_waves(
    waves: Sequence[Wave],
    path: Path,
    command: str,
    said: Sequence[str] = (),
    show: Sequence[str] = (),
) -> None:
    """Write a page if the file ends in .html, otherwise a PNG picture.

    Parameters
    ----------
    command : str
        What made it, for a page.
    said : sequence of str
        Lines above the waveforms of a page.
    show : sequence of str
        Panes of ``FOLDED`` that a picture has, too; a page has them all.
    """
    if path.suffix.lower() not in PAGES:
        save(waveforms(waves, show), path)
        return
    from sensorless.report.page import render  # loads Jinja, which other commands do without

    data = {"maps": {}, "curves": [], "cases": {"run": [packed(wave) for wave in waves]}}
    more = any(pane.key in FOLDED for pane in waves[0].panes)
    page = render(
        "waves.html.j2", data, title=waves[0].title, said=said, more=more, command=command
    )
    write_atomic(path, page)

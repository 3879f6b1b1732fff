"""Makes empty figures and writes figures as PNG. Needs matplotlib."""

import io
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from sensorless.errors import UserError
from sensorless.files import check_writable, is_device, write_atomic

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    "hfi": "#d1495b",
    "smo": "#2e86ab",
    "blend": "#1b1b1e",
    "twin": "#8d99ae",
    "ref": "#f2a541",
}
PALETTE = {
    "own": "#16191d",
    "twin": "#b3bcc8",
    "observer": "#0072b2",
    "hfi": "#d1495b",
    "ref": "#e69f00",
    "ekf": "#009e73",
    "faint": "#b5d6ea",
    "blush": "#e9a0ab",
    "text": "#16191d",
    "muted": "#565d66",
    "bad": "#b3151f",
}
"""Of waveforms, as in the style of a page."""
PNG = ".png"
DPI = 120
LAYOUT: Literal["constrained"] | None = "constrained"
"""No text lies over another; takes as long as drawing."""
LARGE = 100_000
"""Pictures larger than this [byte] get a palette: waveforms do, maps with gradients do not."""


def require_matplotlib() -> None:
    """Check before any work that figures can be drawn.

    Raises
    ------
    UserError
        Matplotlib is missing.
    """
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise UserError("plots need matplotlib; run: pip install 'sensorless[plot]'") from None


def check_picture(path: Path | None, others: Sequence[str] = ()) -> None:
    """Check before any work that a picture can be drawn to a file; None means no file.

    ``others`` are suffixes that are no pictures and need no matplotlib.

    Raises
    ------
    UserError
        The file cannot be written, its name asks for another format, or matplotlib is missing.
    """
    check_writable(path, "plot")
    if path is None or path.suffix.lower() in others:
        return
    if path.suffix.lower() != PNG and not is_device(path):
        known = " or ".join((PNG, *others))
        raise UserError(f"plot: {str(path)!r}: give a file whose name ends in {known}")
    require_matplotlib()


def new_figure(
    size: tuple[float, float], rows: int = 1, columns: int = 1, **shared: Any
) -> "tuple[Figure, list[list[Axes]]]":
    """Return a figure without a display, and its axes row by row.

    Parameters
    ----------
    size : tuple of float
        Width and height [inch].
    rows, columns : int
    **shared
        What ``Figure.subplots`` takes besides.
    """
    require_matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout=LAYOUT)
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False, **shared)
    return figure, [list(row) for row in grid]


def save(figure: "Figure", path: Path) -> None:
    """Write a figure as PNG, whole or not at all."""
    write_atomic(path, png(figure))


def png(figure: "Figure") -> bytes:
    """Return a figure as PNG; one above ``LARGE`` with a palette, which is a third of the size."""
    from PIL import Image

    buffer = io.BytesIO()
    with warnings.catch_warnings():  # a letter that the font lacks is drawn as a box
        warnings.filterwarnings("ignore", "Glyph .* missing from", UserWarning)
        figure.savefig(buffer, format="png", dpi=DPI)
    if len(buffer.getvalue()) <= LARGE:
        return buffer.getvalue()
    picture = Image.open(buffer).convert("RGB")
    small = io.BytesIO()
    picture.quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return small.getvalue()

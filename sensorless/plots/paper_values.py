"""Values that the source paper prints, as lines in pictures of our runs."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOUR = "#1b1b1e"
Dash = Literal["--", ":", "-."]
DASHES: tuple[Dash, ...] = ("--", ":", "-.")
"""One for each label of a picture."""


@dataclass(frozen=True)
class PaperValue:
    """A line in the units of a picture's axis."""

    value: float
    label: str = "paper"
    """Lines of one label share an entry in the legend."""
    span: tuple[float, float] | None = None
    """Stretch of the other axis that it holds on; None: all of it."""
    upright: bool = False
    """A value of the horizontal axis."""


def draw(axes: "Axes", values: Iterable[PaperValue]) -> None:
    """Draw the lines over what is there."""
    known: dict[str, Dash] = {}
    for one in values:
        label = "_" if one.label in known else one.label
        dash = known.setdefault(one.label, DASHES[len(known) % len(DASHES)])
        low, high = one.span or (0.0, 1.0)
        line = axes.vlines if one.upright else axes.hlines
        across = axes.get_xaxis_transform() if one.upright else axes.get_yaxis_transform()
        line(
            one.value,
            low,
            high,
            transform=axes.transData if one.span else across,
            colors=COLOUR,
            linestyles=dash,
            linewidth=1.2,
            label=label,
        )

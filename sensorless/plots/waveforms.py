"""Draws runs over time as a picture. Needs the extra ``plot``."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

from sensorless.plots.figure import PALETTE, new_figure
from sensorless.plots.wave import FOLDED, Wave

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HEIGHT = 2.4
"""Of a pane [inch]."""
TITLE = 90
"""Characters of a line above a column."""


def waveforms(waves: Sequence[Wave], show: Sequence[str] = ()) -> "Figure":
    """Panes over time, one column a run; ``show`` names those of ``FOLDED`` that are wanted.

    Bands and marks have their names at the top.
    """
    shown = [pane.key for pane in waves[0].panes if pane.key not in FOLDED or pane.key in show]
    figure, axes = new_figure(
        (7.0 * len(waves) + 1.5, HEIGHT * len(shown) + 0.6),
        rows=len(shown),
        columns=len(waves),
        sharex=True,
        sharey="row",
    )
    for column, wave in zip(zip(*axes, strict=True), waves, strict=True):
        panes = {pane.key: pane for pane in wave.panes}
        for ax, key in zip(column, shown, strict=True):
            for curve in panes[key].curves:
                style = (0, tuple(0.7 * x for x in curve.dash)) if curve.dash else "-"
                colour, width = PALETTE[curve.colour], 0.7 * curve.width
                ax.plot(wave.t, curve.values, color=colour, lw=width, ls=style, label=curve.name)
            _mark(ax, wave)
            ax.grid(alpha=0.3)
            _legend(ax)
        column[0].set_title(fill(wave.title, TITLE), pad=24, fontsize=10)
        _name(column[0], wave)
        column[-1].set_xlabel("time [s]")
    for row, key in zip(axes, shown, strict=True):
        sides = [pane for wave in waves for pane in wave.panes if pane.key == key]
        row[0].set_ylabel(sides[0].label.replace(", ", "\n").replace(": ", "\n"), fontsize=9)
        spans = [pane.span for pane in sides if pane.span is not None]
        if spans:
            row[0].set_ylim(min(low for low, _ in spans), max(high for _, high in spans))
    return figure


def _mark(ax: "Axes", wave: Wave) -> None:
    for begin, end, _, colour in wave.bands:
        ax.axvspan(begin, end, color=PALETTE[colour], alpha=0.2 if colour == "bad" else 0.4, lw=0)
    for at, _, colour in wave.marks:
        ax.axvline(at, color=PALETTE[colour], lw=1.0)


def _name(ax: "Axes", wave: Wave) -> None:
    """Say what the bands and marks are; each below the one before, so that none hides another."""
    named = [(begin, what, colour) for begin, _, what, colour in wave.bands]
    for j, (at, what, colour) in enumerate([*named, *(mark for mark in wave.marks if mark[1])]):
        ax.annotate(
            f" {what}",
            (at, 0.97 - 0.12 * (j % 4)),
            xycoords=("data", "axes fraction"),
            va="top",
            fontsize=8,
            color=PALETTE["muted" if colour == "faint" else colour],
        )


def _legend(ax: "Axes") -> None:
    if not ax.get_legend_handles_labels()[0]:
        ax.text(0.5, 0.5, "none", transform=ax.transAxes, ha="center", color=PALETTE["muted"])
        ax.set_yticks([])
        return
    legend = ax.legend(
        ncols=5, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 0.98), frameon=False
    )
    for line in legend.get_lines():
        line.set(linewidth=2.0)

"""Maps of where lock holds over speed and load, one per policy. Needs the extra ``plot``."""

import math
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from sensorless.evaluation.results import Envelope, Results
from sensorless.machine.motor import Motor
from sensorless.plots.figure import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

SHOWN = 12.0
"""End of the colour scale [deg]."""
NAME = 30
"""Characters of a policy's name that have room in a line above a map."""
LINE = 0.18
"""Height of a line of text [inch]."""
LOST, BEYOND = "#3d1020", "#9aa0a6"


def envelope_maps(results: Results, motor: Motor) -> "Figure":
    """Angle error (RMS) where each policy holds lock; dark where it is lost.

    Grey: the sensored twin was lost too, so that the point is beyond the machine.

    Raises
    ------
    UserError
        Matplotlib is missing.
    """
    n = len(results.policies)
    columns = n if n <= 4 else 3
    rows = math.ceil(n / columns)
    names = [fill(name, NAME) for name in results.policies]
    more = max(name.count("\n") for name in names) * rows + (columns == 1)  # lines of text
    figure, axes = new_figure(
        (2.9 * columns + 1.1, 3.1 * rows + 0.7 + LINE * more),
        rows=rows,
        columns=columns,
        sharex=True,
        sharey=True,
    )
    places = [ax for row in axes for ax in row]
    images = [
        _map(ax, name, policy, motor)
        for ax, name, policy in zip(places, names, results.policies.values(), strict=False)
    ]
    _name_quadrants(places[0])
    for ax in places[n:]:
        ax.set_axis_off()
    for j in range(columns):
        last = axes[(n - 1 - j) // columns][j]
        last.set_xlabel("speed [r/min]")
        last.tick_params(labelbottom=True)
    for row in axes:
        row[0].set_ylabel("load torque [N m]")
    _legend(figure, min(columns, 2))
    figure.colorbar(images[-1], ax=places, label="angle error, RMS [° el.]", extend="max")
    return figure


def _map(ax: "Axes", name: str, policy: dict[str, Any], motor: Motor) -> "QuadMesh":
    found = Envelope.of(policy["scenarios"])
    grid = np.linspace(-1.0, 1.0, len(found.lost))
    speed, load = grid * motor.n_rated_rpm, grid * motor.tau_rated
    held = np.ma.masked_where(found.lost, found.error)
    image = ax.pcolormesh(speed, load, held, vmin=0.0, vmax=SHOWN, cmap="YlGnBu", shading="nearest")
    for colour, cells in ((LOST, found.lost), (BEYOND, found.beyond)):
        ax.pcolormesh(
            speed,
            load,
            np.ma.masked_where(~cells, np.zeros(cells.shape)),
            cmap=_one_colour(colour),
            shading="nearest",
        )
    ax.axhline(0.0, color="k", lw=0.4, alpha=0.5)
    ax.axvline(0.0, color="k", lw=0.4, alpha=0.5)
    ax.set_title(f"{name}\nkeeps lock in {found.held_pct:.1f} % of the feasible", fontsize=10)
    return image


def _name_quadrants(ax: "Axes") -> None:
    for x, y in ((0.03, 0.03), (0.03, 0.97), (0.97, 0.03), (0.97, 0.97)):
        ax.text(
            x,
            y,
            "motoring" if x == y else "regenerating",
            transform=ax.transAxes,
            ha="left" if x < 0.5 else "right",
            va="bottom" if y < 0.5 else "top",
            fontsize=7,
            bbox={"facecolor": "w", "alpha": 0.8, "edgecolor": "none", "pad": 1.0},
        )


def _one_colour(colour: str) -> "Colormap":
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour])


def _legend(figure: "Figure", columns: int) -> None:
    from matplotlib.patches import Patch

    figure.legend(
        handles=[
            Patch(color=LOST, label="lost lock"),
            Patch(color=BEYOND, label="beyond the machine: the sensored twin is lost too"),
        ],
        loc="outside upper center",
        ncols=columns,
        frameon=False,
        fontsize=9,
    )

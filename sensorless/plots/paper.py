"""Pictures of our runs of the paper's experiments. Needs the extra ``plot``."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from sensorless.evaluation.trace import Trace, without_injection
from sensorless.machine.magnetics import Floats
from sensorless.plots.figure import COLOURS, new_figure
from sensorless.plots.paper_values import PaperValue, draw
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = (COLOURS["hfi"], COLOURS["ref"], COLOURS["twin"], COLOURS["smo"])


@dataclass(frozen=True)
class AngleView:
    """How angle errors are drawn."""

    label: str
    factor: float
    """times truth minus estimate"""
    window: float = 1.0
    """end of the run that is shown [s]"""
    paper: Sequence[PaperValue] = ()


ESTIMATE_MINUS_TRUTH = AngleView("estimate − truth [° el.]", -1.0)
"""The paper's sign."""


def angle_traces(traces: dict[str, Trace], title: str, view: AngleView) -> "Figure":
    """Angle errors of several runs."""
    figure, ((axes,),) = new_figure((8.0, 4.2))
    _angles(axes, traces, view)
    axes.set_title(title)
    return figure


def gain_sweep(
    traces: dict[str, Trace],
    view: AngleView,
    worst: dict[str, Floats],
    over: Floats,
    title: str,
) -> "Figure":
    """Angle errors over time, and the largest magnitude of each run of a sweep over the gain.

    Parameters
    ----------
    worst : dict of ndarray
        By name, (n,) largest angle error [deg] at each gain.
    over : ndarray
        (n,) gain over the EMF.
    """
    figure, ((left, right),) = new_figure((12.0, 4.6), columns=2, width_ratios=(1.7, 1.0))
    _angles(left, traces, view)
    for colour, (name, found) in zip((LINES[0], LINES[2]), worst.items(), strict=True):
        right.plot(over, np.abs(found), "o-", color=colour, ms=4, lw=1.0, label=name)
    right.set_xscale("log")
    right.set_xticks(over, [f"{x:g}" for x in over], fontsize=8, rotation=90)
    right.set_xticks([], minor=True)
    right.set_xlabel("gain of the signum over the EMF")
    right.set_ylabel("largest angle error [° el.]")
    right.set_ylim(0.0, None)
    draw(right, [replace(value, value=abs(value.value)) for value in view.paper])
    right.grid(alpha=0.3)
    right.legend(fontsize=8, loc="lower right")
    figure.suptitle(title)
    return figure


def _angles(axes: "Axes", traces: dict[str, Trace], view: AngleView) -> None:
    for colour, (name, t) in zip(LINES, traces.items(), strict=False):
        T_s = float(t["t"][1] - t["t"][0])
        part = slice(-round(view.window / T_s), None)
        axes.plot(
            1e3 * (t["t"][part] - t["t"][part][0]),
            view.factor * np.rad2deg(t["theta_e_err"][part]),
            color=colour,
            lw=0.8,
            label=name,
        )
    draw(axes, view.paper)
    axes.set_xlabel("time [ms]")
    axes.set_ylabel(view.label)
    axes.grid(alpha=0.3)
    _legend_above(axes, 0.25, 3)


def _legend_above(axes: "Axes", share: float, columns: int) -> None:
    """Legend over the curves, in a share of the height that is added for it."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + share * (high - low))
    axes.legend(fontsize=8, ncols=columns, loc="upper left")


@dataclass(frozen=True)
class Printed:
    """What the paper prints for the three panels of ``speed_runs``."""

    speed: Sequence[PaperValue]
    angle: Sequence[PaperValue]
    weight: Sequence[PaperValue]


def speed_runs(published: Trace, corrected: Trace, title: str, paper: Printed) -> "Figure":
    """Speed, angle error and weight of the published and the corrected drive."""
    figure, axes = new_figure((9.0, 7.0), rows=3, sharex=True, height_ratios=(2, 2, 1))
    (speed,), (angle,), (weight,) = axes
    speed.plot(
        published["t"],
        RAD_S_TO_RPM * published["omega_m_ref"],
        color=COLOURS["ref"],
        label="reference",
    )
    for name, t, colour, width in (
        (
            "as published",
            published,
            COLOURS["hfi"],
            3.0,
        ),  # wide, so that the other hides it nowhere
        ("corrected", corrected, COLOURS["smo"], 1.0),
    ):
        speed.plot(t["t"], RAD_S_TO_RPM * t["omega_m"], color=colour, lw=width, label=name)
        angle.plot(t["t"], np.rad2deg(t["theta_e_err"]), color=colour, lw=0.6, label=name)
        weight.plot(t["t"], t["k_s"], color=colour, lw=width, label=name)
    speed.set_ylabel("speed [r/min]")
    angle.set_ylabel("angle error [° el.]\ntruth − estimate")
    weight.set_ylabel("$k_s$\n1 = HFI, 0 = SMO")
    weight.set_xlabel("time [s]")
    speed.set_title(title)
    panels = ((speed, paper.speed), (angle, paper.angle), (weight, paper.weight))
    for one, values in panels:
        draw(one, values)
        one.grid(alpha=0.3)
        _legend_above(one, 0.45 if one is weight else 0.2, 4)
    return figure


def hand_over(
    runs: dict[str, dict[str, Trace]], title: str, paper: dict[str, list[PaperValue]]
) -> "Figure":
    """Torque over time while the speed goes up and down, hard switch against blend."""
    figure, (row,) = new_figure((10.0, 4.2), columns=len(runs), sharey=True)
    for one, (drive, pair) in zip(row, runs.items(), strict=True):
        for colour, (rule, t) in zip((COLOURS["hfi"], COLOURS["smo"]), pair.items(), strict=True):
            one.plot(t["t"], without_injection(t), color=colour, lw=0.8, label=rule)
        draw(one, paper[drive])
        one.set_title(drive)
        one.set_xlabel("time [s]")
        one.set_xlim(1.0, None)
        one.set_ylim(0.0, None)
        one.grid(alpha=0.3)
        one.legend(fontsize=8)
    row[0].set_ylabel("torque without injection band [N m]")
    figure.suptitle(title)
    return figure

"""Pictures of our runs of the paper's experiments. Needs the extra ``plot``."""

from typing import TYPE_CHECKING

import numpy as np

from sensorless.evaluation.trace import Trace
from sensorless.plots.figure import COLOURS, new_figure
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINES = (COLOURS["hfi"], COLOURS["ref"], COLOURS["twin"], COLOURS["smo"])


def angle_traces(
    traces: dict[str, Trace], title: str, axis: tuple[str, float], window: float = 1.0
) -> "Figure":
    """Angle errors of several runs over their last ``window`` [s], times the axis' factor."""
    label, factor = axis
    figure, ((axes,),) = new_figure((8.0, 4.2))
    for colour, (name, t) in zip(LINES, traces.items(), strict=False):
        T_s = float(t["t"][1] - t["t"][0])
        part = slice(-round(window / T_s), None)
        axes.plot(
            1e3 * (t["t"][part] - t["t"][part][0]),
            factor * np.rad2deg(t["theta_e_err"][part]),
            color=colour,
            lw=0.8,
            label=name,
        )
    axes.set_xlabel("time [ms]")
    axes.set_ylabel(label)
    axes.set_title(title)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, ncols=2)
    return figure


def speed_runs(published: Trace, corrected: Trace, title: str) -> "Figure":
    """Speed, angle error and weight of the published and the corrected drive."""
    figure, axes = new_figure((9.0, 7.0), rows=3, sharex=True, height_ratios=(2, 2, 1))
    (speed,), (angle,), (weight,) = axes
    speed.plot(
        published["t"],
        RAD_S_TO_RPM * published["omega_m_ref"],
        color=COLOURS["ref"],
        label="reference",
    )
    for name, t, colour in (
        ("as published", published, COLOURS["hfi"]),
        ("corrected", corrected, COLOURS["smo"]),
    ):
        speed.plot(t["t"], RAD_S_TO_RPM * t["omega_m"], color=colour, lw=1.2, label=name)
        angle.plot(t["t"], np.rad2deg(t["theta_e_err"]), color=colour, lw=0.6, label=name)
        weight.plot(t["t"], t["k_s"], color=colour, lw=1.0, label=name)
    speed.set_ylabel("speed [r/min]")
    angle.set_ylabel("angle error [° el.]\ntruth − estimate")
    weight.set_ylabel("$k_s$\n1 = HFI, 0 = SMO")
    weight.set_xlabel("time [s]")
    speed.set_title(title)
    for one in (speed, angle, weight):
        one.grid(alpha=0.3)
    speed.legend(fontsize=8)
    angle.legend(fontsize=8)
    return figure


def hand_over(runs: dict[str, dict[str, Trace]], title: str) -> "Figure":
    """Torque over time while the speed goes up and down, hard switch against blend."""
    figure, (row,) = new_figure((10.0, 4.2), columns=len(runs), sharey=True)
    for one, (drive, pair) in zip(row, runs.items(), strict=True):
        for colour, (rule, t) in zip((COLOURS["hfi"], COLOURS["smo"]), pair.items(), strict=True):
            tau = 0.5 * (t["tau"] + np.concatenate([t["tau"][:1], t["tau"][:-1]]))
            one.plot(t["t"], tau, color=colour, lw=0.8, label=rule)
        one.set_title(drive)
        one.set_xlabel("time [s]")
        one.set_xlim(1.0, None)
        one.set_ylim(0.0, None)
        one.grid(alpha=0.3)
        one.legend(fontsize=8)
    row[0].set_ylabel("torque without injection band [N m]")
    figure.suptitle(title)
    return figure

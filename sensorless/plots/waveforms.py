"""Waveforms of a drive over time."""

from typing import TYPE_CHECKING

import numpy as np

from sensorless.core.api import Array
from sensorless.evaluation.trace import Trace, lost_cause
from sensorless.plots.figure import COLOURS, new_figure
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ALARM = "#c0392b"
"""Colour of alarms and recovery."""


def waveforms(traces: dict[str, Trace]) -> "Figure":
    """Speed, torque, angle errors and weight over time, one column per run; keys are titles.

    A dashed line is the verdict of lost lock, a red one an alarm of the drive, red shade the time
    in which it seeks its rotor again.
    """
    figure, axes = new_figure(
        (7.0 * len(traces) + 1.5, 9.5),
        rows=4,
        columns=len(traces),
        sharex=True,
        sharey="row",
        height_ratios=(3, 2.4, 2.4, 1.2),
    )
    worst = max(_quantile(t["theta_e_err"][t["starting"] == 0.0]) for t in traces.values())
    for column, (title, t) in zip(zip(*axes, strict=True), traces.items(), strict=True):
        _speeds(column[0], t)
        _torques(column[1], t)
        _angles(column[2], t)
        column[2].set_ylim(-max(6.0, 1.6 * worst), max(6.0, 1.6 * worst))
        column[3].plot(t["t"], t["k_s"], color=COLOURS["blend"])
        column[3].set_ylim(-0.05, 1.05)
        column[3].set_xlabel("time [s]")
        cause = lost_cause(t)
        column[0].set_title(title + (f" — lost: {cause}" if cause else ""), pad=24)
        for ax in column:
            ax.grid(alpha=0.3)
            _shade_start(ax, t)
            _shade_lost(ax, t)
        for ax in column[:3]:
            legend = ax.legend(
                ncols=4, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False
            )
            for line in legend.get_lines():
                line.set(linewidth=2.0, alpha=1.0)
    labels = (
        "speed [r/min]",
        "torque [N m]",
        "angle error [° el.]\ntruth − estimate",
        "$k_s$\n1 HFI, 0 observer",
    )
    for row, label in zip(axes, labels, strict=True):
        row[0].set_ylabel(label, fontsize=9)
    return figure


def _shade_start(ax: "Axes", t: Trace) -> None:
    """Shade the time in which the drive was still looking for its rotor."""
    seeking = t["t"][t["starting"] > 0.0]
    if len(seeking):
        ax.axvspan(seeking[0], seeking[-1], color="0.88", lw=0)


def _shade_lost(ax: "Axes", t: Trace) -> None:
    """Mark the verdict and the drive's own alarms, and shade where it seeks its rotor again."""
    if t["judged"].any():
        ax.axvline(float(t["t"][t["judged"]][0]), color="0.2", lw=1.0, ls="--")
    for begins in t["t"][np.flatnonzero(np.diff(t["alarm"].astype(np.int8), prepend=0) == 1)]:
        ax.axvline(float(begins), color=ALARM, lw=1.0)
    edges = np.diff(t["recovering"].astype(np.int8), prepend=0, append=0)
    for a, b in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        ax.axvspan(float(t["t"][a]), float(t["t"][b - 1]), color=ALARM, alpha=0.15, lw=0)


def _quantile(x: Array) -> float:
    """Bound on 99.9 % of the errors, at most 90 [deg]."""
    return min(float(np.quantile(np.abs(np.rad2deg(x)), 0.999)), 90.0) if len(x) else 90.0


def _speeds(ax: "Axes", t: Trace) -> None:
    ax.plot(t["t"], RAD_S_TO_RPM * t["omega_m_ref"], color=COLOURS["ref"], label="reference")
    ax.plot(
        t["t"],
        RAD_S_TO_RPM * t["omega_m_twin"],
        color=COLOURS["twin"],
        lw=2.5,
        label="sensored twin",
    )
    ax.plot(t["t"], RAD_S_TO_RPM * t["omega_m"], color=COLOURS["blend"], lw=1.0, label="sensorless")
    ax.plot(t["t"], RAD_S_TO_RPM * t["omega_m_hat"], color=COLOURS["smo"], lw=0.6, label="estimate")


def _torques(ax: "Axes", t: Trace) -> None:
    band = _pairs(t["tau"])
    ax.plot(t["t"], t["tau"], color=COLOURS["smo"], lw=0.4, alpha=0.5, label="torque")
    ax.plot(t["t"], band, color=COLOURS["blend"], lw=0.8, label="without injection band")
    ax.plot(t["t"], t["tau_twin"], color=COLOURS["twin"], label="sensored twin")
    ax.plot(t["t"], t["tau_load"], color=COLOURS["ref"], label="load")


def _angles(ax: "Axes", t: Trace) -> None:
    for key, name in (("_hfi", "hfi"), ("_smo", "smo"), ("", "blend")):
        error = np.rad2deg(t[f"theta_e_err{key}"])
        label = {"hfi": "HFI", "smo": "observer", "blend": "blend"}[name]
        ax.plot(t["t"], error, color=COLOURS[name], lw=0.7, label=label)


def _pairs(x: Array) -> Array:
    """Mean of two successive samples."""
    return np.asarray(0.5 * (x + np.concatenate([x[:1], x[:-1]])))

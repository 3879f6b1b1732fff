"""Figure of a fitted flux map. Needs the extra ``plot``."""

from typing import TYPE_CHECKING

import numpy as np

from sensorless.machine.map_fit import MapFit
from sensorless.plots.figure import COLOURS, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def map_fit(name: str, fit: MapFit, what: str) -> "Figure":
    """Map and model, or ``what`` the errors are of: current over flux, and where it errs."""
    figure, axes = new_figure((10.0, 8.0), rows=2, columns=2)
    model = fit.i + fit.error
    inside = fit.inside(fit.i_max)
    for k, (axis, letter) in enumerate(zip(axes[0], "dq", strict=True)):
        psi = fit.psi[inside, k]
        axis.plot(psi, fit.i[inside, k], "o", ms=3, color=COLOURS["hfi"], label="map")
        axis.plot(psi, model[inside, k], ".", ms=3, color=COLOURS["smo"], label=what)
        axis.set_xlabel(f"$\\psi_{letter}$ [Vs]")
        axis.set_ylabel(f"$i_{letter}$ [A]")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    percent = 100.0 * fit.error[inside] / fit.i_rated
    top = max(float(np.abs(percent).max()), 1e-9)
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    for k, (axis, letter) in enumerate(zip(axes[1], "dq", strict=True)):
        i_d, i_q = fit.i[inside].T
        points = axis.scatter(i_d, i_q, c=percent[:, k], s=22, cmap="coolwarm", vmin=-top, vmax=top)
        axis.plot(
            fit.i_rated * np.cos(angle), fit.i_rated * np.sin(angle), color=COLOURS["twin"], lw=1
        )
        rms = fit.rms_percent(fit.i_rated)[k]
        axis.set_title(f"error of $i_{letter}$, {rms:.2f} % RMS within rated current", fontsize=10)
        axis.set_xlabel("$i_d$ [A]")
        axis.set_ylabel("$i_q$ [A]")
        axis.set_aspect("equal")
        figure.colorbar(points, ax=axis, label="% of rated current")
    figure.suptitle(f"{name}: flux map and {what}")
    return figure

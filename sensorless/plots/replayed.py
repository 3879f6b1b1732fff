"""Figure of a replayed log. Needs the extra ``plot``."""

from typing import TYPE_CHECKING, Any

import numpy as np

from sensorless.plots.figure import COLOURS, new_figure
from sensorless.replay.replay import Replay
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OTHER = "#6a994e"
"""Colour of an estimator that other figures do not have."""


def replayed(r: Replay) -> "Figure":
    """Speed, angle error (angle, if there is no encoder) and weight over time."""
    figure, axes = new_figure((9.0, 8.0), rows=3, sharex=True, height_ratios=(2, 2.4, 1))
    (speed,), (angle,), (weight,) = axes
    t, theta_e = r.log.t, r.log.theta_e
    if theta_e is not None:
        window = max(1, round(0.005 / r.motor.T_s))
        turned = np.unwrap(theta_e)
        true = (turned[window:] - turned[:-window]) / (t[window:] - t[:-window])
        middle = 0.5 * (t[window:] + t[:-window])
        rpm = RAD_S_TO_RPM / r.motor.n_p * true
        speed.plot(middle, rpm, color=COLOURS["twin"], lw=2.5, label="encoder, over 5 ms")
    for name, estimate in r.estimates.items():
        colour = COLOURS.get(name, OTHER)
        style: dict[str, Any] = {"color": colour, "lw": 0.8, "label": r.label(name)}
        speed.plot(t, RAD_S_TO_RPM / r.motor.n_p * estimate.omega_e, **style)
        error = r.error(name)
        shown = np.rad2deg(estimate.theta_e if error is None else error)
        angle.plot(t, np.where(estimate.valid, shown, np.nan), **style)
    weight.plot(t, r.k_s, color=COLOURS["blend"])
    weight.set_ylim(-0.05, 1.05)
    speed.set_ylabel("speed [r/min]")
    angle.set_ylabel(
        "angle [° el.]" if theta_e is None else "angle error [° el.]\ntruth − estimate"
    )
    weight.set_ylabel(f"$k_s$\n1 = HFI, 0 = {r.observer}")
    weight.set_xlabel("time [s]")
    for ax in (speed, angle, weight):
        ax.grid(alpha=0.3)
    speed.legend(ncols=5, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return figure

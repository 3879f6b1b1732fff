"""Figures of a machine's check: what it reaches, and what injection sees."""

from typing import TYPE_CHECKING

import numpy as np

from sensorless.machine.magnetics import flux
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import polar, top_speeds
from sensorless.plots.figure import COLOURS, new_figure
from sensorless.suitability.seen import Seen
from sensorless.units import RAD_S_TO_RPM

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def reach(motor: Motor) -> "Figure":
    """Largest torque over speed within rated and within largest current, and the rated point."""
    figure, ((axes,),) = new_figure((8.0, 4.0))
    i = polar(motor)
    psi = flux(motor.saturation, i)
    tau = 1.5 * motor.n_p * (psi[:, 0] * i[:, 1] - psi[:, 1] * i[:, 0])
    top = top_speeds(motor, i, psi) / motor.n_p * RAD_S_TO_RPM
    size = np.hypot(*i.T)
    speed = np.linspace(0.0, 1.5 * motor.n_rated_rpm, 151)
    for limit, colour, label in (
        (motor.i_max, COLOURS["smo"], "i_max"),
        (motor.i_rated, COLOURS["hfi"], "i_rated"),
    ):
        inside = size <= (1.0 + 1e-9) * limit
        best = [float(tau[inside & (top >= n)].max(initial=0.0)) for n in speed]
        axes.plot(speed, best, color=colour, label=f"{label} = {limit:g} A")
    axes.plot(motor.n_rated_rpm, motor.tau_rated, "o", color=COLOURS["blend"], label="rated point")
    axes.set_xlabel("speed [r/min]")
    axes.set_ylabel("torque [N m]")
    axes.set_title(f"{motor.name}: reach from {motor.u_dc:g} V")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return figure


def signal(motor: Motor, seen: Seen) -> "Figure":
    """Inductance ratio, cross-coupling, and the angle's noise over the current."""
    figure, ((top,), (mid,), (low,)) = new_figure((8.0, 7.0), rows=3, sharex=True)
    size = np.hypot(*seen.signal.i.T)
    top.plot(size, seen.signal.ratio, color=COLOURS["smo"])
    top.axhline(1.0, color=COLOURS["twin"], lw=1)
    top.set_ylabel("inductance ratio")
    top.set_title(f"{motor.name}: what injection of {motor.u_inj:g} V sees")
    mid.plot(size, seen.cross_deg, color=COLOURS["hfi"])
    mid.set_ylabel("cross-coupling [° el.]")
    low.plot(size, seen.signal.noise_deg, color=COLOURS["blend"], label="noise, RMS")
    low.plot(size, seen.signal.step_deg, color=COLOURS["ref"], label="one step of the converter")
    low.set_ylabel("angle [° el.]")
    low.set_xlabel("current on the line of maximum torque per ampere [A]")
    low.legend(fontsize=8)
    for axes in (top, mid, low):
        axes.axvline(motor.i_rated, color=COLOURS["twin"], lw=1, ls="--")
        axes.grid(alpha=0.3)
    return figure

"""Figure of an identified cross-coupling. Needs the extra ``plot``."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from sensorless.design.control import operating_line
from sensorless.identify.cross_coupling import CrossCoupling, lookup
from sensorless.machine.magnetics import cross_angle
from sensorless.plots.figure import COLOURS, new_figure
from sensorless.plots.paper_values import PaperValue, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def cross_coupling(c: CrossCoupling, paper: Sequence[PaperValue] = ()) -> "Figure":
    """Measured angle over the torque current with line, table and closed form; residuals below."""
    figure, ((top,), (low,)) = new_figure((8.0, 7.0), rows=2, sharex=True, height_ratios=(2.2, 1.0))
    i_q, deg = c.i[:, 1], np.rad2deg
    edge = float(max(np.max(np.abs(i_q)), np.max(np.abs(c.left_i_q))))
    x = np.linspace(-edge, edge, 201)
    line = operating_line(c.motor, c.mtpa)
    theory = lookup(line[:, 1], cross_angle(c.motor, line), x)
    top.plot(
        x,
        deg(theory),
        color=COLOURS["twin"],
        lw=4,
        label="closed form on the drive's own operating line (Eq. 16)",
    )
    top.plot(
        x,
        deg(c.line.slope * x),
        color=COLOURS["ref"],
        label=f"line up to {c.line.up_to:.1f} A, {deg(c.line.slope):.2f} °/A, "
        f"R² {c.line.fit.r2:.4f} there",
    )
    top.plot(
        x,
        deg(lookup(c.nodes, c.table, x)),
        color=COLOURS["smo"],
        label=f"table, fitted with its compensation on, R² {c.table_fit.r2:.4f}",
    )
    top.plot(i_q, deg(c.angle), "o", color=COLOURS["hfi"], ms=4, label="measured, no compensation")
    here = deg(cross_angle(c.motor, c.i))  # without compensation the current leaves that line
    top.plot(i_q, here, "+", color="black", ms=7, label="closed form at the currents measured")
    draw(top, paper)
    top.set_ylabel("cross-coupling [° el.]\ntruth − injection estimate")
    top.set_title(
        f"{c.motor.name}: cross-coupling at {c.speed_rpm:.0f} r/min, "
        + ("MTPA" if c.mtpa else "$i_d$ = 0")
    )
    gap = deg(c.angle - c.line.slope * i_q)
    low.plot(i_q, gap, "o-", color=COLOURS["ref"], ms=3, label="measured − line")
    low.plot(c.left_i_q, deg(c.left), "o-", color=COLOURS["smo"], ms=3, label="drive on the table")
    low.set_ylabel("error left [° el.]")
    low.set_xlabel("torque current $i_q$, encoder frame [A]")
    for axes in (top, low):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    return figure

"""A schedule as maps. Drawing them needs the extra ``plot``."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, Array
from sensorless.envs.signals import SIGNALS
from sensorless.machine.motor import Motor
from sensorless.plots.figure import new_figure
from sensorless.table.ks_table import Axis, KsTable

if TYPE_CHECKING:
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Sheet:
    """Weights of a table over two of its axes."""

    title: str
    note: str
    """values of the other axes; empty if there are none"""
    x: Array
    """(columns,) in the unit of the label"""
    y: Array
    """(rows,)"""
    x_label: str
    y_label: str
    k_s: Array
    """(rows, columns)"""


def sheets(
    name: str, table: KsTable, reference: KsTable, motor: Motor, columns: int, rows: int
) -> list[Sheet]:
    """Sample a table, and Eq. 25 over the same axes first; a third axis at three values.

    A fourth axis is at its middle, and signals that are no axis are 0.
    """
    across, up = table.axes[0], _second(table)
    slices = _slices(table)
    x, y = np.linspace(across.lo, across.hi, columns), np.linspace(up.lo, up.hi, rows)
    obs = np.zeros((len(y), len(x), SIGNAL_N), dtype=np.float32)
    obs[..., SIGNAL_NAMES.index(across.signal)] = x
    obs[..., SIGNAL_NAMES.index(up.signal)] = y[:, None]
    out = []
    parts = [("Eq. 25", "", reference, slices[0][1]), *((name, s, table, v) for s, v in slices)]
    for title, note, one, values in parts:
        for signal, value in values.items():
            obs[..., SIGNAL_NAMES.index(signal)] = value
        k_s = one.evaluate(obs.reshape(-1, SIGNAL_N)).reshape(obs.shape[:2])
        labels = (_label(across), _label(up))
        out.append(Sheet(title, note, x * _factor(across, motor), y, *labels, k_s))
    return out


def schedule_maps(name: str, table: KsTable, reference: KsTable, motor: Motor) -> "Figure":
    """k_s of a table beside that of Eq. 25, as ``sheets`` has them."""
    drawn = sheets(name, table, reference, motor, 161, 121)
    figure, (row,) = new_figure((3.3 * len(drawn) + 1.2, 3.9), columns=len(drawn), sharey=True)
    image: QuadMesh | None = None
    for ax, s in zip(row, drawn, strict=True):
        image = ax.pcolormesh(s.x, s.y, s.k_s, vmin=0.0, vmax=1.0, cmap="cividis", shading="auto")
        ax.contour(s.x, s.y, s.k_s, levels=[0.1, 0.5, 0.9], colors="w", linewidths=0.8)
        ax.set_title(f"{s.title}\n{s.note}" if s.note else s.title, fontsize=10)
        ax.set_xlabel(s.x_label)
    across, up = table.axes[0], _second(table)
    nodes = np.meshgrid(
        np.linspace(across.lo, across.hi, across.n) * _factor(across, motor),
        np.linspace(up.lo, up.hi, up.n),
    )
    for ax in row[1:] if len(table.axes) > 1 else ():
        ax.plot(*(part.ravel() for part in nodes), ".", color="w", ms=2.5, alpha=0.8)
    row[0].set_ylabel(drawn[0].y_label)
    assert image is not None
    figure.colorbar(image, ax=row, label="$k_s$ (1 = HFI, 0 = observer)")
    return figure


def _second(table: KsTable) -> Axis:
    """Second axis of the map; another signal if the table has only one."""
    if len(table.axes) > 1:
        return table.axes[1]
    other = "torque_current" if table.axes[0].signal != "torque_current" else "speed"
    return Axis(other, -1.5 if other == "torque_current" else 0.0, 1.5, 2)


def _slices(table: KsTable) -> list[tuple[str, dict[str, float]]]:
    """Title and values of the signals of the third and fourth axis, for each map."""
    if len(table.axes) < 3:
        return [("", {})]
    third, *fourth = table.axes[2:]
    fixed = {a.signal: 0.5 * (a.lo + a.hi) for a in fourth}
    note = "".join(f", {a.signal} {fixed[a.signal]:g}" for a in fourth)
    return [
        (f"{third.signal} {value:g}{note}", {third.signal: value, **fixed})
        for value in (third.lo, 0.5 * (third.lo + third.hi), third.hi)
    ]


def _factor(axis: Axis, motor: Motor) -> float:
    return motor.n_rated_rpm if axis.signal == "speed" else 1.0


def _label(axis: Axis) -> str:
    if axis.signal == "speed":
        return "|speed estimate| [r/min]"
    if axis.signal == "torque_current":
        return "torque current / rated\n< 0 regenerating, > 0 motoring"
    scale = next(s.scale for s in SIGNALS if s.name == axis.signal)
    return f"{axis.signal} / {scale}"

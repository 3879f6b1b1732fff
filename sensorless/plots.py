"""Figures: waveforms of a drive, and a schedule beside Eq. 25. Needs the extra ``plot``."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensorless.core_api import SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.files import write_atomic
from sensorless.ks_table import KsTable
from sensorless.motor import Motor
from sensorless.trace import Trace, lost_cause

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {
    "hfi": "#d1495b",
    "smo": "#2e86ab",
    "blend": "#1b1b1e",
    "twin": "#8d99ae",
    "ref": "#f2a541",
}
RPM = 30.0 / np.pi


def _figure(**options: Any) -> Any:
    """Return figure and axes of matplotlib, without a display."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise UserError("plots need matplotlib: pip install 'sensorless[plot]'") from None
    size = options.pop("figsize")
    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(**options)


def save(figure: "Figure", path: Path) -> None:
    """Write a figure as PNG, whole or not at all."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=120)
    write_atomic(path, buffer.getvalue())


def waveforms(t: Trace, title: str) -> "Figure":
    """Speed, torque, angle errors and weight over time."""
    figure, (speed, torque, angle, weight) = _figure(
        figsize=(9.0, 9.5), nrows=4, sharex=True, height_ratios=(3, 2.4, 2.4, 1.2)
    )
    x = t["t"]
    speed.plot(x, RPM * t["omega_m_ref"], color=COLOURS["ref"], label="reference")
    speed.plot(x, RPM * t["omega_m_twin"], color=COLOURS["twin"], lw=2.5, label="sensored twin")
    speed.plot(x, RPM * t["omega_m"], color=COLOURS["blend"], lw=1.0, label="sensorless")
    speed.plot(x, RPM * t["omega_m_hat"], color=COLOURS["smo"], lw=0.6, label="estimate")
    speed.set_ylabel("speed [r/min]")
    torque.plot(x, t["tau"], color=COLOURS["smo"], lw=0.4, alpha=0.5, label="torque")
    torque.plot(x, _pairs(t["tau"]), color=COLOURS["blend"], lw=0.8, label="without injection band")
    torque.plot(x, t["tau_twin"], color=COLOURS["twin"], label="sensored twin")
    torque.plot(x, t["tau_load"], color=COLOURS["ref"], label="load")
    torque.set_ylabel("torque [N m]")
    for key, name in (("_hfi", "hfi"), ("_smo", "smo"), ("", "blend")):
        angle.plot(
            x,
            np.rad2deg(t[f"theta_e_err{key}"]),
            color=COLOURS[name],
            lw=0.7,
            label={"hfi": "HFI", "smo": "SMO", "blend": "blend"}[name],
        )
    span = float(np.nanquantile(np.abs(np.rad2deg(t["theta_e_err"])), 0.999))
    angle.set_ylim(-max(6.0, 1.6 * span), max(6.0, 1.6 * span))
    angle.set_ylabel("angle error [° el.]\ntruth − estimate")
    weight.plot(x, t["k_s"], color=COLOURS["blend"])
    weight.set_ylim(-0.05, 1.05)
    weight.set_ylabel("$k_s$\n1 = HFI, 0 = SMO")
    weight.set_xlabel("time [s]")
    for axes in (speed, torque, angle):
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, fontsize=8, frameon=False)
    for axes in (speed, torque, angle, weight):
        axes.grid(alpha=0.3)
    cause = lost_cause(t)
    figure.suptitle(title + (f" — lost: {cause}" if cause else ""))
    return figure  # type: ignore[no-any-return]


def _pairs(x: Any) -> Any:
    """Mean of each two samples in a row."""
    return 0.5 * (x + np.concatenate([x[:1], x[:-1]]))


def schedules(tables: dict[str, KsTable], motor: Motor) -> "Figure":
    """k_s over speed and torque current, one map a schedule; other signals at zero."""
    figure, axes = _figure(
        figsize=(4.6 * len(tables) + 0.8, 4.0), ncols=len(tables), sharey=True, squeeze=False
    )
    speed, current = np.linspace(0.0, 1.0, 151), np.linspace(-1.5, 1.5, 121)
    obs = np.zeros((len(current), len(speed), len(SIGNAL_NAMES)), dtype=np.float32)
    obs[..., SIGNAL_NAMES.index("speed")] = speed
    obs[..., SIGNAL_NAMES.index("torque_current")] = current[:, None]
    image = None
    for ax, (name, table) in zip(axes[0], tables.items(), strict=True):
        k_s = table.evaluate(obs.reshape(-1, len(SIGNAL_NAMES))).reshape(obs.shape[:2])
        image = ax.pcolormesh(
            speed * motor.n_rated_rpm,
            current,
            k_s,
            vmin=0.0,
            vmax=1.0,
            cmap="viridis",
            shading="auto",
        )
        ax.contour(
            speed * motor.n_rated_rpm,
            current,
            k_s,
            levels=[0.1, 0.5, 0.9],
            colors="w",
            linewidths=0.8,
        )
        ax.set_title(name)
        ax.set_xlabel("|speed estimate| [r/min]")
    axes[0, 0].set_ylabel("torque current / rated\n< 0 regenerating, > 0 motoring")
    figure.colorbar(image, ax=axes[0].tolist(), label="$k_s$ (1 = HFI, 0 = SMO)")
    return figure  # type: ignore[no-any-return]

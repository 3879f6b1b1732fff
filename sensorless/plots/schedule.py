"""Figures of a report: losses by place, and the schedule as maps. Needs the extra ``plot``."""

from typing import TYPE_CHECKING, Any

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.envs.signals import SIGNALS
from sensorless.evaluation.results import Results
from sensorless.evaluation.results_tables import speed_labels
from sensorless.machine.motor import Motor
from sensorless.plots.figure import new_figure
from sensorless.table.ks_table import Axis, KsTable

if TYPE_CHECKING:
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure

MOST_POLICIES = 8
"""Most policies in a figure."""


def lost_by_place(results: Results) -> "Figure":
    """Share lost in each quadrant and at each speed, with Wilson intervals, one colour per policy.

    At most ``MOST_POLICIES`` are shown: the first two, the bounds, and the best others.
    """
    shown = _shown(results.policies)
    figure, ((upper,), (lower,)) = new_figure((11.0, 6.4), rows=2)
    for ax, key in zip((upper, lower), ("by_quadrant", "by_speed"), strict=True):
        labels: list[str] = []
        for j, (name, policy) in enumerate(shown.items()):
            block = policy[key]
            labels = list(block.get("place", ())) or [
                label.removeprefix("speed ") for label in speed_labels(block["from_rated_speed"])
            ]
            rate = 100.0 * np.array(block["lost_rate"])
            low, high = 100.0 * np.array(block["lost_ci"]).T
            shift = 0.7 * ((j + 0.5) / len(shown) - 0.5)
            ax.errorbar(
                np.arange(len(labels)) + shift,
                rate,
                yerr=np.maximum([rate - low, high - rate], 0.0),
                fmt="o",
                ms=4,
                lw=1.2,
                color=f"C{j}",
                label=name + (" (bound)" if policy["bound"] else ""),
            )
        ax.set_xticks(range(len(labels)), labels, fontsize=9)
        for j in range(1, len(labels)):
            ax.axvline(j - 0.5, color="k", lw=0.4, alpha=0.3)
        ax.set_xlim(-0.5, len(labels) - 0.5)
        ax.set_ylim(0.0, None)
        ax.set_ylabel("lost there [%]\n(95 % interval)")
        ax.grid(axis="y", alpha=0.3)
    lower.set_xlabel("speed over rated speed, of the sensored twin")
    upper.legend(ncols=5, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    return figure


def _shown(policies: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    kept = [*list(policies)[:2], *(name for name, policy in policies.items() if policy["bound"])]
    rest = [name for name in policies if name not in kept]
    rest.sort(key=lambda name: policies[name]["lost_rate"])
    kept += rest[: max(0, MOST_POLICIES - len(kept))]
    return {name: policy for name, policy in policies.items() if name in kept}


def schedule_maps(name: str, table: KsTable, reference: KsTable, motor: Motor) -> "Figure":
    """k_s of a table beside that of Eq. 25 over the same axes; a third axis at three values.

    A fourth axis is at its middle, and signals that are no axis are 0.
    """
    across, up = table.axes[0], _second(table)
    slices = _slices(table)
    figure, (row,) = new_figure(
        (3.3 * (1 + len(slices)) + 1.2, 3.9), columns=1 + len(slices), sharey=True
    )
    x, y = np.linspace(across.lo, across.hi, 161), np.linspace(up.lo, up.hi, 121)
    obs = np.zeros((len(y), len(x), SIGNAL_N), dtype=np.float32)
    obs[..., SIGNAL_NAMES.index(across.signal)] = x
    obs[..., SIGNAL_NAMES.index(up.signal)] = y[:, None]
    image: QuadMesh | None = None
    parts = [("Eq. 25", reference, slices[0][1]), *((f"{name}{s}", table, v) for s, v in slices)]
    for ax, (title, one, values) in zip(row, parts, strict=True):
        for signal, value in values.items():
            obs[..., SIGNAL_NAMES.index(signal)] = value
        k_s = one.evaluate(obs.reshape(-1, SIGNAL_N)).reshape(obs.shape[:2])
        shown = x * _factor(across, motor)
        image = ax.pcolormesh(shown, y, k_s, vmin=0.0, vmax=1.0, cmap="viridis", shading="auto")
        ax.contour(shown, y, k_s, levels=[0.1, 0.5, 0.9], colors="w", linewidths=0.8)
        ax.set_title(title, fontsize=10)
        ax.set_xlabel(_label(across, motor))
    nodes = np.meshgrid(
        np.linspace(across.lo, across.hi, across.n) * _factor(across, motor),
        np.linspace(up.lo, up.hi, up.n),
    )
    for ax in row[1:] if len(table.axes) > 1 else ():
        ax.plot(*(part.ravel() for part in nodes), ".", color="w", ms=2.5, alpha=0.8)
    row[0].set_ylabel(_label(up, motor))
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
    note = "".join(f"\n{a.signal} {fixed[a.signal]:g}" for a in fourth)
    return [
        (f"\n{third.signal} {value:g}{note}", {third.signal: value, **fixed})
        for value in (third.lo, 0.5 * (third.lo + third.hi), third.hi)
    ]


def _factor(axis: Axis, motor: Motor) -> float:
    return motor.n_rated_rpm if axis.signal == "speed" else 1.0


def _label(axis: Axis, motor: Motor) -> str:
    if axis.signal == "speed":
        return "|speed estimate| [r/min]"
    if axis.signal == "torque_current":
        return "torque current / rated\n< 0 regenerating, > 0 motoring"
    scale = next(s.scale for s in SIGNALS if s.name == axis.signal)
    return f"{axis.signal} / {scale}"

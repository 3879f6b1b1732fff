"""Learning curves of training runs, and what other schedules reach on the same scenarios."""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensorless.agents.loading import CONFIG
from sensorless.agents.train.run_folder import PROGRESS, design_and_motor
from sensorless.agents.validation import validate
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.objective import Cost
from sensorless.plots.figure import new_figure
from sensorless.policies import shipped
from sensorless.policies.registry import make_policy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RULES = {
    "smo": "linear-tuned",
    "flux": "flux_observer-tuned",
    "coupled": "linear-coupled-tuned",
}
"""Tuned ramp that a trained schedule has to beat, by the estimator of its drive."""
CURVES = (
    ("objective", "objective [%]"),
    ("lost_rate", "lost in validation [%]"),
    ("torque_dev", "torque deviation [% of rated]"),
    ("torque_ripple", "torque ripple [% of rated]"),
)
"""Columns of ``progress.csv``, which are fields of ``Cost``, with their labels."""
STYLES = ("--", ":", "-.")

Curve = dict[str, Any]
"""Columns of ``progress.csv`` by name, each (validations,)."""


def curves_of(folder: Path, *, alone: bool = False) -> dict[str, Curve]:
    """Validation over training time of the runs inside a folder, or of the folder's own run.

    Columns are by name. A run that contains other runs is a copy of one of them and is left out,
    unless it is wanted ``alone``.
    """
    out = {}
    inside = [] if alone else sorted(folder.glob(f"*/{PROGRESS}"))
    for path in inside or [folder / PROGRESS]:
        if path.is_file() and (path.parent == folder or not any(path.parent.glob(f"*/{PROGRESS}"))):
            with path.open(encoding="utf-8", newline="") as file:
                rows = list(csv.DictReader(file))
            if rows:
                out[path.parent.resolve().name] = {
                    key: np.array([float(row[key]) for row in rows]) for key in rows[0]
                }
    return out


def levels_of(folder: Path, words: Sequence[str]) -> dict[str, Cost]:
    """Cost of other policies on the scenarios that a run was validated on, by name.

    Parameters
    ----------
    folder : Path
        Folder of a training run.
    words : sequence of str
        Policies, as in ``sensorless.policies.registry.known``.

    Raises
    ------
    UserError
        The folder has no training run, or its motor has no such policy.
    """
    design, motor = design_and_motor(folder)
    size = int(json.loads((folder / CONFIG).read_text(encoding="utf-8"))["train"]["validate_size"])
    factory = SimFactory(motor, design)
    return {word: validate(make_policy(word, motor), factory, size) for word in words}


def shipped_levels(folder: Path) -> dict[str, Cost]:
    """Cost of the tuned ramp and the reference on a run's scenarios, if they are shipped.

    The reference is for one machine only.
    """
    if not (folder / CONFIG).is_file():
        return {}
    rule = rule_for(folder)
    words = [rule] if shipped.tuned_file(rule).is_file() else []
    reference = shipped.reference_run()
    if reference is not None and _motor_of(reference) == _motor_of(folder):
        words.append("reference")
    return levels_of(folder, words)


def rule_for(folder: Path) -> str:
    """Name of the tuned ramp on the estimator of a run."""
    return RULES.get(design_and_motor(folder)[0].estimator, RULES["smo"])


def _motor_of(folder: Path) -> str:
    return design_and_motor(folder)[1].digest


def learning_curves(curves: Mapping[str, Curve], levels: Mapping[str, Cost]) -> "Figure":
    """Objective and its parts in validation over training time: a line per run and per level."""
    figure, axes = new_figure((11.0, 6.4), rows=2, columns=2)
    for ax, (key, label) in zip([*axes[0], *axes[1]], CURVES, strict=True):
        for name, curve in curves.items():
            minutes, value = curve["seconds"] / 60.0, 100.0 * curve[key]
            (line,) = ax.plot(minutes, value, "-o", ms=2.5, lw=1.0, label=name)
            best = int(np.argmin(curve["objective"]))
            ax.plot(minutes[best], value[best], "*", ms=11, color=line.get_color())
        for (name, cost), style in zip(levels.items(), STYLES, strict=False):
            ax.axhline(100.0 * getattr(cost, key), color="k", lw=1.0, ls=style, label=name)
        ax.set_xlabel("training time [min]")
        ax.set_ylabel(label)
        ax.grid(alpha=0.3)
    axes[0][1].set_ylim(0.0, None)
    axes[0][0].legend(fontsize=8, title="★ kept", title_fontsize=8)
    return figure

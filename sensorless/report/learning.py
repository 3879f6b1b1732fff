"""Learning curves of training runs, and what other schedules reach on the same scenarios."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.agents.loading import CONFIG
from sensorless.agents.train.curve import COLUMNS, PROGRESS, rows
from sensorless.agents.train.run_folder import design_and_motor, setting_of
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.objective import LOST_WEIGHT, Cost
from sensorless.evaluation.validation import validate
from sensorless.policies import shipped
from sensorless.policies.registry import make_policy

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
COLOURS = ("observer", "hfi", "ekf", "ref", "own")

Curve = dict[str, Any]
"""Columns of ``progress.csv`` by name, each (validations,)."""


def curves_of(folder: Path, *, alone: bool = False) -> dict[str, Curve]:
    """Validation over training time of the runs inside a folder, or of the folder's own run.

    Columns are by name. A run that contains other runs is a copy of one of them and is left out,
    unless it is wanted ``alone``.

    Raises
    ------
    UserError
        A file is damaged.
    """
    out = {}
    inside = [] if alone else sorted(folder.glob(f"*/{PROGRESS}"))
    for path in inside or [folder / PROGRESS]:
        if path.is_file() and (path.parent == folder or not any(path.parent.glob(f"*/{PROGRESS}"))):
            found = rows(path.parent)
            if found:
                out[path.parent.resolve().name] = {
                    name: np.array([float(row[name]) for row in found]) for name in COLUMNS
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
    size = setting_of(folder, "validate_size")
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


def learning(run: str) -> tuple[list[dict[str, Any]], str]:
    """Panels with the curves of a run's folder, and what they show; empty if it has none.

    Raises
    ------
    UserError
        A file of the run is damaged.
    """
    made = shipped.reference_run(run)
    folder = made or Path(run)
    found = curves_of(folder, alone=made is not None) if folder.is_dir() else {}
    if not found:
        return [], ""
    levels = {name: cost for name, cost in shipped_levels(folder).items() if name != run}
    times = np.unique(np.concatenate([c["seconds"] for c in found.values()]))
    panels = []
    for key, label in CURVES:
        curves = []
        for j, (name, curve) in enumerate(found.items()):
            known = dict(zip(curve["seconds"], 100.0 * curve[key], strict=True))
            best = curve["seconds"][np.flatnonzero(curve["best"])[-1:]]
            values = [known.get(t) for t in times]
            kept = [x if t in best else None for t, x in zip(times, values, strict=True)]
            style = {"colour": COLOURS[j % len(COLOURS)], "gaps": True, "points": True}
            curves.append({"name": name, "values": values, "width": 1.4, **style})
            kept_style = {**style, "colour": "bad", "width": 4}
            curves.append({"name": f"{name}, kept", "values": kept, **kept_style})
        for j, (name, cost) in enumerate(levels.items()):
            flat = [100.0 * getattr(cost, key)] * len(times)
            style = {"colour": "muted", "width": 1.4, "dash": [6, 3 + 6 * j]}
            curves.append({"name": name, "values": flat, **style})
        x = (times / 60.0).tolist()
        panels.append({"label": label, "xLabel": "training time [min]", "x": x, "curves": curves})
    lines = f" Dashed: {' and '.join(levels)} on the same scenarios." if levels else ""
    return panels, (
        "Validation during training, on scenarios that neither training nor judging uses. The "
        "first point is the start of training, the large one what was kept. The objective is "
        f"{LOST_WEIGHT:g} times the lost rate plus torque deviation plus torque ripple.{lines}"
    )

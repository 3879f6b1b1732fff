"""Learning curves of a training run, for a page."""

from pathlib import Path
from typing import Any

import numpy as np

from sensorless.evaluation.objective import LOST_WEIGHT
from sensorless.plots.learning import CURVES, curves_of, shipped_levels
from sensorless.policies import shipped

COLOURS = ("observer", "hfi", "ekf", "ref", "own")


def learning(run: str) -> tuple[list[dict[str, Any]], str]:
    """Panels with the curves of a run's folder, and what they show; empty if it has none."""
    made = shipped.reference_run(run)
    folder = made or Path(run)
    found = curves_of(folder, alone=made is not None) if folder.is_dir() else {}
    if not found:
        return [], ""
    levels = shipped_levels(folder)
    times = np.unique(np.concatenate([c["seconds"] for c in found.values()]))
    panels = []
    for key, label in CURVES:
        curves = []
        for j, (name, curve) in enumerate(found.items()):
            known = dict(zip(curve["seconds"], 100.0 * curve[key], strict=True))
            best = curve["seconds"][int(np.argmin(curve["objective"]))]
            values = [known.get(t) for t in times]
            kept = [x if t == best else None for t, x in zip(times, values, strict=True)]
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

"""How long PPO takes to pass the tuned rule, and to come near the reference, in validation.

    python studies/learning_time.py RUN ... [--rule linear-tuned] [--reference reference]

RUN is the folder of a training run. Both levels are judged on the very scenarios that the run was
validated on while it learned; its time is the clock of the machine it ran on. Writes
``results/studies/learning_time.json``.
"""

import argparse
import dataclasses
import platform
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.errors import UserError, in_one_line
from sensorless.evaluation.objective import OBJECTIVE
from sensorless.files import ensure_writable, write_record
from sensorless.report.learning import Curve, curves_of, levels_of, rule_for

WANTED = {"rule": 120.0, "reference": 900.0}
"""Time that each may take [s]."""
NEAR = 0.02
"""Share of its objective within which the reference, the best of its seeds, counts as reached."""


def crossing(curve: Curve, level: float) -> dict[str, Any] | None:
    """First validation below an objective; None if there is none.

    ``seconds`` and ``steps`` of training then, and whether it ``stays`` there in all that follow.
    """
    below = curve["objective"] < level
    if not below.any():
        return None
    first = int(np.argmax(below))
    return {
        "seconds": float(curve["seconds"][first]),
        "steps": int(curve["steps"][first]),
        "stays": bool(below[first:].all()),
    }


def study(folder: Path, rule: str, reference: str) -> dict[str, Any]:
    """One run against both levels.

    Raises
    ------
    UserError
        No training run, no such policy, or none for the run's motor.
    """
    curve = curves_of(folder).get(folder.resolve().name)
    if curve is None:
        raise UserError(f"run: {str(folder)!r} has no learning curve; give a training run")
    levels = levels_of(folder, [rule, reference])
    best = int(np.argmin(curve["objective"]))
    return {
        "start": float(curve["objective"][0]),
        "best": {
            "objective": float(curve["objective"][best]),
            "seconds": float(curve["seconds"][best]),
        },
        "trained_s": float(curve["seconds"][-1]),
        "levels": {word: dataclasses.asdict(c) | {"objective": c.objective}
                   for word, c in levels.items()},
        "rule": crossing(curve, levels[rule].objective),
        "reference": crossing(curve, (1.0 + NEAR) * levels[reference].objective),
    }  # fmt: skip


def in_time(runs: dict[str, dict[str, Any]], what: str) -> int:
    """Runs that got there in the time that is wanted."""
    return sum(r[what] is not None and r[what]["seconds"] <= WANTED[what] for r in runs.values())


def show(runs: dict[str, dict[str, Any]], rule: str, reference: str) -> Table:
    """Table for the terminal."""
    table = Table(title=f"time to pass {rule} and to reach {reference}")
    for heading in ("run", "start", "best", "rule", "passed", "reference", "reached"):
        table.add_column(heading, justify="left" if heading == "run" else "right")
    for name, run in runs.items():
        cells = [f"{run['start']:.4f}", f"{run['best']['objective']:.4f}"]
        for what, word in (("rule", rule), ("reference", reference)):
            cells += [f"{run['levels'][word]['objective']:.4f}", _when(run[what])]
        table.add_row(Path(name).name, *cells)
    counts = (
        f"{verb} in {WANTED[what]:.0f} s: {in_time(runs, what)} of {len(runs)}"
        for what, verb in (("rule", "passed"), ("reference", "reached"))
    )
    table.caption = f"start, best, rule, reference: objective in validation; {'; '.join(counts)}"
    return table


def _when(found: dict[str, Any] | None) -> str:
    if found is None:
        return "never"
    stays = "stays" if found["stays"] else "not for good"
    return f"{found['seconds']:.0f} s\n{found['steps'] / 1e6:.1f} M\n{stays}"


def main() -> None:
    """Judge, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN")
    parser.add_argument("--rule", help="the ramp tuned on the first run's estimator by default")
    parser.add_argument("--reference", default="reference")
    parser.add_argument("--out", type=Path, default=Path("results/studies/learning_time.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    rule = options.rule or rule_for(options.runs[0])
    runs = {str(run): study(run, rule, options.reference) for run in options.runs}
    console = Console()
    console.print(show(runs, rule, options.reference))
    record = {
        "rule": rule, "reference": options.reference, "objective": OBJECTIVE,
        "near": NEAR, "wanted_s": WANTED, "machine": platform.platform(),
        "in_time": {what: in_time(runs, what) for what in WANTED}, "runs": runs,
    }  # fmt: skip
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)

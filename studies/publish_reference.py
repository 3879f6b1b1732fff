"""Publish what ``make reference`` made: the best table, tuned rules, and one page of results.

    python studies/publish_reference.py build/reference results/reference --suite stress-1

The page has one table a suite; every training run is one row of ``runs.csv``. The HTML report with
its pictures, the results files and the other runs stay where they were made.
"""

import argparse
import csv
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sensorless.errors import in_one_line
from sensorless.evaluation.results_tables import number
from sensorless.files import ensure_writable, write_atomic

COLUMNS = (
    ("torque_dev_rms", "torque deviation [%]", 100.0, 2),
    ("torque_ripple_rms", "torque ripple [%]", 100.0, 2),
    ("torque_ripple_window", "ripple in the window [%]", 100.0, 2),
    ("overshoot_excess_pct", "overshoot beyond the twin's [%]", 1.0, 2),
    ("angle_err_rms_deg", "angle error [°]", 1.0, 2),
    ("injection_share", "injection on [%]", 100.0, 1),
)
"""Name, heading, factor and decimals."""
BEST = ("table.json", "config.json", "progress.csv")
RUN_KEYS = ("steps", "seconds", "objective", "lost_rate", "torque_dev", "torque_ripple")
"""Of the validation with the least objective."""


def page(results: list[dict[str, Any]]) -> str:
    """Markdown with one table a suite; means over the scenarios survived, 95 % intervals."""
    parts = [
        "# Results of the reference\n\nWritten by `make reference`, which judges every tuned rule "
        "and every training run. Lost: share of all scenarios (95 % Wilson interval). Other "
        "columns: mean over the scenarios survived ± half its 95 % bootstrap interval.\n"
    ]
    for result in results:
        head = ["policy", "estimator", "lost [%]", *(heading for _, heading, _, _ in COLUMNS)]
        rows = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
        for name, policy in result["policies"].items():
            cells = [name, policy["estimator"] or "position sensor", _lost(policy)]
            cells += [_cell(policy, *column) for column in COLUMNS]
            rows.append("| " + " | ".join(cells) + " |")
        parts.append(
            f"\n## `{result['suite']}`, seed {result['seed']}, {result['size']} scenarios, motor "
            f"`{result['motor']}`\n\n" + "\n".join(rows) + "\n"
        )
    return "".join(parts)


def _lost(policy: dict[str, Any]) -> str:
    low, high = policy["lost_ci"]
    return f"{100 * policy['lost_rate']:.2f} ({100 * low:.2f}–{100 * high:.2f})"


def _cell(policy: dict[str, Any], key: str, _: str, factor: float, digits: int) -> str:
    low, high = policy[f"{key}_ci"]
    value = policy[key]
    if value is None or low is None:
        return "–"
    return f"{number(factor * value, digits)} ± {number(0.5 * factor * (high - low), digits)}"


def runs(folder: Path) -> str:
    """CSV with the best validation of every training run below a folder."""
    lines = [",".join(("run", *RUN_KEYS))]
    for path in sorted(folder.glob("**/*-[0-9]*/progress.csv")):
        if "runs" in path.relative_to(folder).parts:
            continue
        with path.open(encoding="utf-8", newline="") as file:
            best = min(csv.DictReader(file), key=lambda row: float(row["objective"]))
        name = path.parent.relative_to(folder).as_posix()
        lines.append(",".join((name, *(best[key] for key in RUN_KEYS))))
    return "\n".join(lines) + "\n"


def publish(made: Path, shipped: Path, suites: Sequence[str]) -> None:
    """Replace what the package ships by what was made."""
    results = [
        json.loads((made / "report" / f"results-{suite}.json").read_text(encoding="utf-8"))
        for suite in suites
    ]
    ensure_writable(shipped / "tuned")
    for path in (made / "tuned").glob("*.json"):
        shutil.copy(path, shipped / "tuned")
    for name in BEST:
        shutil.copy(made / name, shipped)
    write_atomic(shipped / "runs.csv", runs(made))
    write_atomic(shipped / "results.md", page(results))


def main() -> None:
    """Publish one folder into another."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("made", type=Path, help="folder that make reference worked in")
    parser.add_argument("shipped", type=Path, help="folder that the package ships")
    parser.add_argument(
        "--suite", action="append", required=True, help="suite on the page; repeat for several"
    )
    words = parser.parse_args()
    publish(words.made, words.shipped, words.suite)
    print(f"published {words.made} in {words.shipped}")


if __name__ == "__main__":
    in_one_line(main)

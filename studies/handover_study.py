"""Torque and overshoot in the hand-over window, on the corrected drive and on the published one.

    python studies/handover_study.py [--search 40]

All policies run the same scenarios of `handoff` on either drive (`sensorless/reproduce/case.py` has
the paper's), each beside a twin of its own drive, and are paired with Eq. 25 on both. `quietest`
bounds what a schedule can do: the logistic rule tuned by CMA-ES for nothing but a quiet window, on
the tuning scenarios. Writes ``results/studies/handover.json``.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cma
import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.baselines.logistic import RULE
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows, suite
from sensorless.errors import in_one_line
from sensorless.evaluation.aggregate import paired, summary
from sensorless.evaluation.evaluate import Scores, score
from sensorless.evaluation.metrics.ripple import HANDOVER, torque_ripple_window
from sensorless.evaluation.objective import weighted
from sensorless.evaluation.results_tables import difference, number
from sensorless.evaluation.rollout import rollout
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy
from sensorless.reproduce.case import CORRECTED, PUBLISHED
from sensorless.versions import versions

RULE_OF_THE_PAPER = "eq25"
POLICIES = {
    "corrected": (
        RULE_OF_THE_PAPER, "hysteresis", "linear-tuned", "logistic-tuned", "gated-tuned",
        "ramp-tuned", "flux_observer-tuned", "logistic-flux-tuned", "reference-flux",
        "ppo-smo-ks", "hfi", "oracle", "sensored",
    ),
    "published": (RULE_OF_THE_PAPER, "hysteresis", "hfi", "sensored"),
}  # fmt: skip
DRIVES = {"corrected": CORRECTED, "published": PUBLISHED}
COLUMNS = {
    "torque_ripple_window": (100.0, 2),
    "torque_p2p_window": (100.0, 1),
    "overshoot_clean_pct": (1.0, 2),
    "overshoot_clean_above": (100.0, 1),
}
SEARCHED = 58
"""Scenarios of the search: each profile of ``handoff`` once."""


def quietest(motor: Motor, design: DriveDesign, generations: int, seed: int) -> dict[str, float]:
    """Parameters of the logistic rule with the least ripple in the window, losing nothing."""
    scenarios = suite("handoff", motor, seed, SEARCHED, role="tune")
    factory = SimFactory(motor, design)
    low, high = np.array([p.search for p in RULE.parameters]).T

    def cost(x: Sequence[float]) -> float:
        r = rollout(RULE.build("x", values(x), motor), scenarios, factory)
        kept = r.lost == 0
        ripple = np.nanmean(torque_ripple_window(r)[kept]) if kept.any() else 1.0
        return float(weighted(np.mean(~kept), 0.0, ripple))

    def values(x: Sequence[float]) -> dict[str, float]:
        scaled = low + np.asarray(x) * (high - low)
        return {p.name: float(v) for p, v in zip(RULE.parameters, scaled, strict=True)}

    start = (np.array(list(RULE.defaults().values())) - low) / (high - low)
    es = cma.CMAEvolutionStrategy(
        np.clip(start, 0.05, 0.95), 0.2,
        {"bounds": [0.0, 1.0], "seed": seed, "verbose": -9, "verb_log": 0},
    )  # fmt: skip
    for _ in range(generations):
        points = es.ask()
        es.tell(points, [cost(x) for x in points])
    return values(es.result.xbest)


def compare(
    drive: str, scores: dict[tuple[str, str], Scores], name: str, seed: int
) -> dict[str, Any]:
    """Means of a policy, and its differences to Eq. 25 on its own and on the published drive."""
    mine = scores[drive, name]
    lost, metrics = mine.lost, {key: mine.metrics[key] for key in COLUMNS}
    out: dict[str, Any] = summary(lost, metrics, seed)
    for where in DRIVES:
        other = scores[where, RULE_OF_THE_PAPER]
        theirs = {key: other.metrics[key] for key in COLUMNS}
        out[f"to {where} eq25"] = paired(lost, metrics, other.lost, theirs, seed)
    return out


def show(found: dict[str, dict[str, Any]], drive: str) -> Table:
    """Table for the terminal."""
    table = Table(title=f"{drive} drive")
    for heading in ("policy", "lost [%]", "ripple [%]", "p.-p. [%]", "overshoot [%]", "> 2 % [%]"):
        table.add_column(heading, justify="left" if heading == "policy" else "right")
    for key in (f"to {where} eq25" for where in DRIVES):
        table.add_column(f"ripple {key} [%]", justify="right")
    for name, row in found.items():
        cells = [number(f * row[key], d) for key, (f, d) in COLUMNS.items()]
        pairs = [
            difference(row[f"to {where} eq25"], "torque_ripple_window", 100.0, 2)
            for where in DRIVES
        ]
        table.add_row(name, number(100.0 * row["lost_rate"], 1), *cells, *pairs)
    return table


def main() -> None:
    """Measure, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument("--size", type=a_count, default=2000)
    parser.add_argument("--search", type=int, default=40, help="generations of CMA-ES; 0: none")
    parser.add_argument("--out", type=Path, default=Path("results/studies/handover.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    motor = Motor.load("paper")
    rows = SuiteRows("handoff", motor, options.seed, options.size)
    policies: dict[tuple[str, str], Policy] = {
        (drive, name): make_policy(name, motor) for drive in DRIVES for name in POLICIES[drive]
    }
    parameters = {}
    if options.search:
        parameters = quietest(motor, CORRECTED, options.search, 1)
        policies["corrected", "quietest"] = RULE.build("quietest", parameters, motor)
    scores = {
        (drive, name): score(policy, rows, SimFactory(motor, DRIVES[drive]))
        for (drive, name), policy in policies.items()
    }
    found = {
        drive: {
            name: compare(drive, scores, name, options.seed) for d, name in scores if d == drive
        }
        for drive in DRIVES
    }
    console = Console(width=150)
    for drive, of_drive in found.items():
        console.print(show(of_drive, drive))
    record = {
        "suite": rows.name, "seed": options.seed, "size": options.size, "window": HANDOVER,
        "quietest": parameters, "generations": options.search, "versions": versions(),
        "designs": {name: asdict(design) for name, design in DRIVES.items()}, "policies": found,
    }  # fmt: skip
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)

"""What drives notice of lost lock, and whether they come back: every suite, estimator and action.

    python studies/lock_study.py [--motor NAME ...] [--estimator NAME ...] [--suite NAME ...]

Eq. 25 with `lost_lock` report and restart. Prints for each machine, estimator and action what
`sensorless evaluate` writes of lost lock, over all suites together. With --out the result is
written to a file.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SUITES, SuiteRows
from sensorless.evaluation.lock import LOCK, lock_summary
from sensorless.evaluation.rollout import CAUSES, at_a_time, rollouts
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

ACTIONS = ("report", "restart")
KNOWN = tuple(name for name in SUITES if name != "starts")
"""Suites whose drives know their angle at first."""
MACHINES = ("paper", "ipmsm_2200w", "pmsyrm_5600w")


def watched(motor: Motor, design: DriveDesign, suites: list[str], seed: int, size: int) -> Any:
    """``lock_summary`` over these suites."""
    policy, factory = make_policy("eq25", motor), SimFactory(motor, design)
    runs = []
    for suite in suites:
        scenarios = SuiteRows(suite, motor, seed, size).draw()
        some = min(64, at_a_time(scenarios, motor))
        runs += list(rollouts(policy, scenarios, factory, some, go_on=True))
    lost = np.concatenate([r.lost for r in runs])
    time = np.concatenate([r.periods for r in runs]) * motor.T_s
    lock = {name: np.concatenate([r.lock[name] for r in runs]) for name in LOCK}
    feasible = (lost & CAUSES["twin"]) == 0
    held = float(time[feasible & (lost == 0)].sum())
    return {**lock_summary(lock, lost, time, CAUSES["twin"]), "held_s": round(held)}


def show(found: list[dict[str, Any]]) -> None:
    """Print one line a machine, estimator and action."""
    table = Table(box=None)
    for heading in ("machine", "estimator", "lost_lock"):
        table.add_column(heading)
    for heading in ("held s", "false alarms", "lost", "detected %", "after ms", "back %"):
        table.add_column(heading, justify="right")
    for row in found:
        n = row["lock_counts"]
        table.add_row(
            *(row[name] for name in ("motor", "estimator", "lost_lock")),
            *(str(x) for x in (row["held_s"], n["false_alarms"], n["lost"])),
            f"{100.0 * row['detected_rate']:.1f}",
            f"{row['detect_ms']:.0f}",
            f"{100.0 * row['recovered_rate']:.0f} of {n['could_recover']}",
        )
    Console(width=130).print(table)


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--motor", nargs="+", default=MACHINES)
    parser.add_argument("--estimator", nargs="+", default=("smo", "flux", "coupled"),
                        choices=tuple(ESTIMATORS))  # fmt: skip
    parser.add_argument("--suite", nargs="+", default=KNOWN, choices=KNOWN)
    parser.add_argument("--action", nargs="+", default=ACTIONS, choices=(*ACTIONS, "stop"))
    parser.add_argument("--seed", type=int, default=977)
    parser.add_argument("--size", type=int, default=65, help="scenarios of a suite")
    parser.add_argument("--out", type=Path, help="file for the result")
    args = parser.parse_args()
    found = []
    for motor in map(Motor.load, args.motor):
        for estimator in args.estimator:
            for action in args.action:
                design = DriveDesign(estimator=estimator, lost_lock=action)
                row = watched(motor, design, list(args.suite), args.seed, args.size)
                found.append({"motor": motor.name, "estimator": estimator, "lost_lock": action}
                             | row)  # fmt: skip
    show(found)
    if args.out is not None:
        record = {"seed": args.seed, "size": args.size, "suites": list(args.suite)}
        record |= {"versions": versions(), "found": found}
        text = json.dumps(record, indent=1, default=float).replace("NaN", "null")
        write_atomic(args.out, text + "\n")


if __name__ == "__main__":
    main()

"""Which signals should the table look at? Trains every set of axes on the same budget.

    python studies/axes_study.py --steps 4000000 --seeds 1 2 3

Budgets are decisions, not minutes, so a busy machine changes nothing. The JSON file is written
after every run: rerun the command to resume, or with more seeds to add to it.
Power needs no axis of its own: torque current is positive when motoring, and a table of speed and
torque current has their product in its span.
"""

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.agents.loading import load_run
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import Scores, score
from sensorless.files import check_writable, ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy, table_named
from sensorless.policy import Policy
from sensorless.versions import versions

SPEED, TORQUE = "speed:0:1:16", "torque_current:-1.5:1.5:5"
SETS = {
    "speed": SPEED,
    "motoring or regenerating": f"{SPEED},torque_current:-0.1:0.1:2",
    "torque current": f"{SPEED},{TORQUE}",
    "disagreement": f"{SPEED},disagreement:-1.5:1.5:5",
    "torque current, disagreement": f"{SPEED},{TORQUE},disagreement:-1.5:1.5:5",
    "torque current, acceleration": f"{SPEED},{TORQUE},acceleration:-10:10:3",
    "torque current, speed error": f"{SPEED},{TORQUE},speed_error:-0.3:0.3:3",
    "torque current, SMO residual": f"{SPEED},{TORQUE},smo_residual:0:1:3",
    "torque current, k_s": f"{SPEED},{TORQUE},k_s:0:1:2",
}
JUDGED = 1
"""Seed of the scenarios that the tables are judged on; validation in training uses 0."""
ASKED = ("motor", "estimator", "set", "seed", "steps", "size")
"""What tells a run from others on the same core."""
NAMES = ("torque_dev_rms", "torque_ripple_rms", "overshoot_pct", "angle_err_rms_deg")


def judged(policy: Policy, factory: SimFactory, size: int) -> Scores:
    """Every metric on stress scenarios of the role ``tune``."""
    return score(policy, suite("stress-1", factory.motor, JUDGED, size, "tune"), factory)


def compared(found: Scores, reference: Scores) -> dict[str, Any]:
    """Lost rates, and means over the scenarios that both survived."""
    both = (found.lost == 0) & (reference.lost == 0)
    out: dict[str, Any] = {
        "lost_rate": float(np.mean(found.lost != 0)),
        "eq25_lost_rate": float(np.mean(reference.lost != 0)),
        "survived_both": int(both.sum()),
    }
    for name in NAMES:
        known = both & np.isfinite(found.metrics[name]) & np.isfinite(reference.metrics[name])
        out[name] = float(np.mean(found.metrics[name][known]))
        out[f"eq25_{name}"] = float(np.mean(reference.metrics[name][known]))
    return out


def main() -> None:
    """Train what is missing in the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=4_000_000, help="decisions of a run")
    parser.add_argument("--seeds", type=a_seed, nargs="+", default=[1, 2, 3])
    parser.add_argument("--size", type=a_count, default=2000, help="scenarios to judge on")
    parser.add_argument("--sets", nargs="+", choices=list(SETS), default=list(SETS))
    parser.add_argument("--motor", default="paper")
    parser.add_argument("--estimator", default="smo", help="of the drive: smo or flux")
    parser.add_argument("--out", type=Path, default=Path("results/studies/axes.json"))
    args = parser.parse_args()
    ensure_writable(args.out.parent)
    check_writable(args.out)
    design = DriveDesign(estimator=args.estimator)
    factory = SimFactory(Motor.load(args.motor), design)
    start = table_named(TrainConfig.start, factory.motor)
    base = TrainConfig(motor=args.motor, steps=args.steps)
    done: list[dict[str, Any]] = (
        json.loads(args.out.read_text(encoding="utf-8"))["runs"] if args.out.exists() else []
    )
    core = versions()["core"]
    known = {tuple(r[name] for name in ASKED) for r in done if r["core"] == core}
    reference: Scores | None = None
    for seed in args.seeds:
        for name in args.sets:
            asked = {"motor": factory.motor.name, "estimator": args.estimator, "set": name}
            asked |= {"seed": seed, "steps": args.steps, "size": args.size}
            if tuple(asked[name] for name in ASKED) in known:
                continue
            if reference is None:
                reference = judged(make_policy("eq25", factory.motor), factory, args.size)
            with tempfile.TemporaryDirectory() as folder:
                run = Path(folder) / "run"
                train(replace(base, axes=SETS[name], seed=seed), design, run, start)
                policy = load_run(run, factory.motor)
            row = compared(judged(policy, factory, args.size), reference)
            done.append({**asked, "axes": SETS[name], "core": core, **row})
            write_record(args.out, {"versions": versions(), "runs": done})
            more = 100.0 * (row["torque_dev_rms"] / row["eq25_torque_dev_rms"] - 1.0)
            print(
                f"{name:32} seed {seed}: lost {100 * row['lost_rate']:.2f} %, torque deviation "
                f"{more:+.1f} % of Eq. 25",
                flush=True,
            )


if __name__ == "__main__":
    in_one_line(main)

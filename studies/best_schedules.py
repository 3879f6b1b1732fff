"""The best schedule for each shipped machine, among Eq. 25 and rules tuned for that machine.

    python studies/best_schedules.py [--motor NAME ...] [--rule linear logistic] [--budget 20000]

Each rule is tuned on the machine as ``sensorless tune`` does, on the default drive, and judged as
``sensorless export`` judges, on scenarios that tuning has not seen. Of those that are better than
Eq. 25 there and do not move the weight at constant speed and load, the one with the least objective
on the tuner's own scenarios counts as best, otherwise Eq. 25 does. So it is the best of these few,
not of all schedules, and PPO is not among them. Writes what ``sensorless motors`` shows. Machines
whose numbers and drive have not changed are not tuned again.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from sensorless.cli.study_numbers import a_seed
from sensorless.design.drive import DriveDesign
from sensorless.errors import in_one_line
from sensorless.evaluation.compare import hops_often
from sensorless.export.judge import judge_export
from sensorless.files import ensure_writable, write_atomic
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.best import RECORD, identity
from sensorless.policies.registry import make_policy
from sensorless.tuning.tune import tune
from sensorless.versions import versions

RULES = ("linear", "logistic")


def study(motor: Motor, rules: list[str], budget: float, seed: int) -> dict[str, Any]:
    """Entry of one machine."""
    design, tuned = DriveDesign(), {}
    for name in rules:
        known = tune(name, motor, design, budget, seed).provenance
        tuned[known["policy"]] = known["best"]
        print(f"  {known['policy']}: objective {known['best']['objective']:.4f}", flush=True)
    order = sorted(tuned, key=lambda spec: float(tuned[spec]["objective"]))
    tried = [(word, judge_export(make_policy(word, motor), motor, design)) for word in order]
    better = [
        (word, judged)
        for word, judged in tried
        if judged.eq25.word == "better" and not hops_often(judged.eq25.hops, judged.eq25.their_hops)
    ]
    if better:
        word, judged = better[0]
        verdict = judged.sentence
    else:
        word, judged = "eq25", judge_export(make_policy("eq25", motor), motor, design)
        verdict = f"no tuned rule is better; the best of them is {tried[0][1].sentence}"
    return {
        "on": identity(motor),
        "policy": word,
        "verdict": verdict,
        "judged": judged.facts(),
        "tuned": tuned,
    }


def main() -> None:
    """Tune and judge what is missing or out of date, and print all of it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    shipped = sorted(path.stem for path in MOTORS.glob("*.toml"))
    parser.add_argument("--motor", nargs="+", default=shipped)
    parser.add_argument("--rule", nargs="+", default=list(RULES))
    parser.add_argument("--budget", type=float, default=20000.0, help="of each rule [s simulated]")
    parser.add_argument("--seed", type=a_seed, default=1)
    parser.add_argument("--out", type=Path, default=RECORD)
    args = parser.parse_args()
    ensure_writable(args.out.parent)
    asked = {"rules": args.rule, "budget_s": args.budget, "seed": args.seed}
    record: dict[str, Any] = {**asked, "machines": {}}
    if args.out.exists():
        old = json.loads(args.out.read_text(encoding="utf-8"))
        record = old if {key: old.get(key) for key in asked} == asked else record
    for name in args.motor:
        motor = Motor.load(name)
        print(name, flush=True)
        if record["machines"].get(motor.name, {}).get("on") != identity(motor):
            record["machines"][motor.name] = study(motor, args.rule, args.budget, args.seed)
            record["versions"] = versions()
            write_atomic(args.out, json.dumps(record, indent=1) + "\n")
        entry = record["machines"][motor.name]
        print(f"  best: {entry['policy']}: {entry['verdict']}", flush=True)


if __name__ == "__main__":
    in_one_line(main)

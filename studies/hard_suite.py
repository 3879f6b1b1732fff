"""Search the scenarios of the suites ``hard`` and ``hard-train``, and write them.

Eq. 25 on the paper's machine: those that its sliding-mode and flux observers lose, and the worst
for the coupled one. Neighbours in the file go to different halves.

    python studies/hard_suite.py
"""

import argparse
from pathlib import Path

from sensorless.cli.study_numbers import a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.finds import HARD, text_of
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import in_one_line
from sensorless.falsify.minimise import minimise
from sensorless.falsify.search import search
from sensorless.files import check_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

SIZES = {"smo": 16_000, "flux": 12_000, "coupled": 12_000}
"""Scenarios to run, by estimator."""


def main() -> None:
    """Search on each estimator, and write all finds into one file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=a_seed, default=1)
    parser.add_argument("--out", type=Path, default=HARD)
    args = parser.parse_args()
    check_writable(args.out)
    motor, found, counts = Motor.load("paper"), [], {}
    for estimator, size in SIZES.items():
        policy = make_policy("eq25", motor)
        factory = SimFactory(motor, DriveDesign(estimator=estimator))
        s = search(policy, factory, "stress", args.seed, size)
        found += [*minimise(policy, factory, s.finds), *(x for x in s.finds if x.lost_at is None)]
        counts[estimator] = {
            "scenarios": s.scenarios, "lost": s.lost, "sampled": s.sampled,
            "sampled_lost": s.sampled_lost, "searches": s.searches,
            "worst": max(x.severity for x in s.finds),
        }  # fmt: skip
        print(estimator, counts[estimator], flush=True)
    facts = {"command": "python studies/hard_suite.py", "policy": "eq25", "seed": args.seed,
             "motor": motor.name, "by_estimator": counts, "versions": versions()}  # fmt: skip
    write_atomic(args.out, text_of(found, facts))
    print(f"wrote {args.out}: {len(found)} scenarios")


if __name__ == "__main__":
    in_one_line(main)

"""Compare a schedule that learned on random machines with tuned linear rules on real ones.

    python studies/motors_study.py
    python studies/motors_study.py --estimator coupled --policy linear-coupled-tuned \
        --against best eq25 --motor brusa_hsm1 ebike_hub formula_wheel ipmsm_2200w pmsrm_15kw \
        pmsyrm_5600w --size 400 --out results/studies/zero_shot.json

Every policy runs the suite `motors` on every shipped machine, none of which the family holds; the
ones under --policy are compared with the ones under --against in pairs. No worse: the Wilson
interval of its lost rate does not lie above the other's, and torque deviation over the scenarios
that both survived is at most 2 % above the other's, with the whole bootstrap interval. The file is
written after every machine: rerun the command to resume. The schedules made on the family are kept
beside it, each with its command. The word best stands for the rule tuned for the machine itself, or
Eq. 25 where that is better (``sensorless motors``).
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.aggregate import paired, summary
from sensorless.evaluation.evaluate import Scores, score
from sensorless.files import check_writable, ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.best import best
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy, TablePolicy
from sensorless.versions import versions

SUITE = "motors"
MARGIN = 0.02
"""Torque deviation that counts as none."""
METRICS = ("torque_dev_rms", "torque_ripple_rms", "overshoot_pct")
FAMILY = "results/studies/motors"
POLICIES = (f"{FAMILY}/ppo", "eq25", "logistic-flux-tuned")
AGAINST = (f"{FAMILY}/linear-family.json", "linear-tuned", "flux_observer")
BEST = "best"
MACHINES = ("ipmsm_2200w", "paper", "pmsyrm_5600w")


def compared(found: Scores, other: Scores, seed: int) -> dict[str, Any]:
    """Lost rates, paired differences over the other's means, and the verdict."""
    own, there = (summary(s.lost, {}, seed) for s in (found, other))
    metrics = {name: found.metrics[name] for name in METRICS}
    apart = paired(found.lost, metrics, other.lost, other.metrics, seed)
    base = apart["there"]
    more = {
        name: {
            "mean": apart[name] / base[name],
            "ci": [x / base[name] for x in apart[f"{name}_ci"]],
        }
        for name in METRICS
    }
    holds = own["lost_ci"][0] <= there["lost_ci"][1]
    return {
        "survived_both": apart["survived_both"],
        "lost_only_here": apart["lost_only_here"],
        "lost_only_there": apart["lost_only_there"],
        "lost_rate_ci": apart["lost_rate_ci"],
        "relative": more,
        "no_worse": bool(holds and more["torque_dev_rms"]["ci"][1] <= MARGIN),
    }


def named(word: str, motor: Motor) -> Policy:
    """Policy by name, or the best of the machine."""
    own = best(motor) if word == BEST else None
    return make_policy(word if own is None else own.policy, motor)


def study(
    name: str, policies: Sequence[str], against: Sequence[str], words: argparse.Namespace
) -> dict[str, Any]:
    """One machine under all policies."""
    motor, seed = Motor.load(name), words.seed
    factory = SimFactory(motor, DriveDesign(estimator=words.estimator))
    rows = SuiteRows(SUITE, motor, seed, words.size)
    scores = {w: score(named(w, motor), rows, factory) for w in (*against, *policies)}
    return {
        "policies": {
            word: summary(s.lost, {m: s.metrics[m] for m in METRICS}, seed)
            for word, s in scores.items()
        },
        "against": {
            other: {word: compared(scores[word], scores[other], seed) for word in policies}
            for other in against
        },
    }


def say(name: str, found: dict[str, Any]) -> None:
    """Print a machine's part of the record."""
    print(name)
    for word, s in found["policies"].items():
        low, high = (100.0 * x for x in s["lost_ci"])
        print(
            f"  {word:24} lost {100 * s['lost_rate']:.2f} % ({low:.2f} to {high:.2f}), torque "
            f"deviation {100 * s['torque_dev_rms']:.2f} %, ripple "
            f"{100 * s['torque_ripple_rms']:.2f} %"
        )
    for other, row in found["against"].items():
        for word, c in row.items():
            dev = c["relative"]["torque_dev_rms"]
            low, high = (100.0 * x for x in dev["ci"])
            print(
                f"  {word} against {other}: torque deviation {100 * dev['mean']:+.1f} % "
                f"({low:+.1f} to {high:+.1f}): {'no worse' if c['no_worse'] else 'WORSE'}",
                flush=True,
            )


def identity(policy: Policy) -> dict[str, str | None] | None:
    """Digest of a policy's table and how it was made, for the record."""
    if not isinstance(policy, TablePolicy):
        return None
    known = policy.table.provenance
    return {"digest": policy.table.digest, "command": known.get("command")}


def main() -> None:
    """Judge what is missing in the file, and print all of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policy", nargs="+", default=list(POLICIES))
    parser.add_argument("--against", nargs="+", default=list(AGAINST))
    parser.add_argument("--motor", nargs="+", default=list(MACHINES))
    parser.add_argument("--estimator", default="smo", help="of policies that bring none")
    parser.add_argument("--seed", type=a_seed, default=11, help="of the scenarios to judge on")
    parser.add_argument("--size", type=a_count, default=1000, help="scenarios a machine")
    parser.add_argument("--out", type=Path, default=Path("results/studies/motors.json"))
    args = parser.parse_args()
    ensure_writable(args.out.parent)
    check_writable(args.out)
    words = (*args.against, *args.policy)
    asked = {
        "suite": SUITE,
        "estimator": args.estimator,
        "seed": args.seed,
        "size": args.size,
        "policies": {w: identity(named(w, Motor.load(args.motor[0]))) for w in words},
        "against": args.against,
        "versions": versions(),
    }
    record: dict[str, Any] = {**asked, "machines": {}}
    if args.out.exists():
        old = json.loads(args.out.read_text(encoding="utf-8"))
        if {key: old.get(key) for key in asked} == asked:
            record = old
    for name in args.motor:
        digest = Motor.load(name).digest
        if record["machines"].get(name, {}).get("digest") != digest:
            found = study(name, args.policy, args.against, args)
            record["machines"][name] = {"digest": digest, **found}
            write_record(args.out, record)
        say(name, record["machines"][name])


if __name__ == "__main__":
    in_one_line(main)

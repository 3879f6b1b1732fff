"""One schedule for all machines, against a rule tuned for each of them.

    python studies/zero_shot.py [--policy fuzzy-coupled-tuned eq25] [--machines 64] [--rule linear]

Draws random machines of the suite `machines`, which neither training nor tuning knows, tunes a rule
on each as ``sensorless tune`` does, and judges it beside the policies on scenarios of ``stress-1``
that tuning has not seen. A policy is as good on a machine if its mean, over the scenarios that both
survive, is at most 2 % above that of the tuned rule. The file is written after every machine: rerun
the command to resume, also with more machines or policies; no machine is tuned twice.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines_suite import machine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.aggregate import paired
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.rollout import are_feasible
from sensorless.files import check_writable, write_record
from sensorless.policies.registry import make_policy
from sensorless.tuning.tune import tune
from sensorless.versions import versions

SUITE = "stress-1"
METRICS = ("torque_dev_rms", "torque_ripple_rms")
MARGIN = 0.02
"""Share by which a mean may be larger and still count as no worse."""


def study(index: int, words: argparse.Namespace, known: Mapping[str, Any]) -> dict[str, Any]:
    """One machine: how many scenarios each policy loses, and its means over the tuned rule's.

    ``known``: its entry in the record so far.
    """
    motor, design, own = machine(words.seed, index), DriveDesign(), known.get("tuned")
    if own is None:
        own = tune(words.rule, motor, design, words.budget, words.tune_seed).provenance["policy"]
    policies = dict(known.get("policies", {}))
    new = [word for word in words.policy if word not in policies]
    if not new:
        return dict(known)
    rows, factory = SuiteRows(SUITE, motor, words.seed, words.size), SimFactory(motor, design)
    found = {w: score(make_policy(w, motor, override=True), rows, factory) for w in (own, *new)}
    tuned = found.pop(own)
    for word, s in found.items():
        ours, theirs = ({m: x.metrics[m] for m in METRICS} for x in (s, tuned))
        apart = paired(s.lost, ours, tuned.lost, theirs, words.seed)
        more = {m: apart[m] / apart["there"][m] for m in METRICS}
        policies[word] = {"lost": count(s.lost), "more": more}
    return {"machine": motor.name, "tuned": own, "lost": count(tuned.lost), "policies": policies}


def count(lost: NDArray[np.int32]) -> int:
    """Scenarios that a drive loses, but its sensored twin does not."""
    return int(np.sum((lost != 0) & are_feasible(lost)))


def summed(machines: list[Mapping[str, Any]], word: str) -> dict[str, float]:
    """Shares of the machines on which a policy is as good, and how many scenarios are lost."""
    rows = [m["policies"][word] for m in machines]
    good = {m: np.array([r["more"][m] <= MARGIN for r in rows]) for m in METRICS}
    lost = np.array([r["lost"] <= m["lost"] for r, m in zip(rows, machines, strict=True)])
    mean = {m: float(np.mean([r["more"][m] for r in rows])) for m in METRICS}
    return {
        **{f"{m}_as_good": float(good[m].mean()) for m in METRICS},
        **{f"{m}_more": mean[m] for m in METRICS},
        "no_more_lost": float(lost.mean()),
        "lost": sum(r["lost"] for r in rows),
        "lost_tuned": sum(m["lost"] for m in machines),
    }


def main() -> None:
    """Tune and judge what is missing in the file, and print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policy", nargs="+", default=["fuzzy-coupled-tuned", "eq25"])
    parser.add_argument("--rule", default="linear", help="that is tuned on every machine")
    parser.add_argument("--machines", type=a_count, default=64)
    parser.add_argument("--budget", type=float, default=20_000.0, help="simulated s of a tuning")
    parser.add_argument("--seed", type=a_seed, default=1, help="of machines and scenarios")
    parser.add_argument("--tune-seed", type=a_seed, default=1)
    parser.add_argument("--size", type=a_count, default=256, help="scenarios a machine")
    parser.add_argument("--out", type=Path, default=Path("results/studies/random_machines.json"))
    words = parser.parse_args()
    check_writable(words.out)
    known = versions()
    asked = {k: v for k, v in vars(words).items() if k not in ("policy", "machines", "out")}
    asked |= {"versions": {name: known[name] for name in ("sensorless", "core")}}
    old = json.loads(words.out.read_text(encoding="utf-8")) if words.out.is_file() else {}
    done = old["machines"] if old.get("asked") == asked else []
    n = words.machines
    before = [*done[:n], *({} for _ in range(n - len(done)))]
    entries = LOCAL.map(lambda job: study(job[0], words, job[1]), enumerate(before))
    for index, entry in enumerate(entries):
        done[index : index + 1] = [entry]
        write_record(words.out, {"asked": asked, "machines": done})
        print(index + 1, json.dumps(entry), flush=True)
    shares = {word: summed(done[: words.machines], word) for word in words.policy}
    print(json.dumps(shares, indent=1))
    write_record(words.out, {"asked": asked, "shares": shares, "machines": done})


if __name__ == "__main__":
    in_one_line(main)

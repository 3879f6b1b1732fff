"""Five seeds of PPO against tuned rules that may set the same numbers.

    python studies/learning_study.py smo-gains
    python studies/learning_study.py smo-gains --seeds 1 --budget 4000 --steps 500000 --size 100

Trains, tunes, picks the best of each in validation, judges all on scenarios that none has seen,
adds what it finds to the JSON file, and with --publish ships the best in results/reference/learned.
What is in the work folder is not made again.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sensorless.agents.loading import load_run, load_table
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.over_seeds import change_over_seeds, survived
from sensorless.evaluation.validation import validate
from sensorless.files import check_writable, write_atomic, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy, table_named
from sensorless.policies.shipped import ALIASES, FOLDER, tuned_file
from sensorless.policies.tuned import Tuned
from sensorless.policy import Policy
from sensorless.table.ks_table import KsTable
from sensorless.tuning.with_gains import LOST_BESIDE, SCHEDULED, STATIC, tune_with_gains
from sensorless.versions import versions

NAMES = ("torque_dev_rms", "torque_ripple_rms", "overshoot_excess_pct", "injection_share")
JUDGED = {"stress-1": (11, 12), "mismatch": (11,), "low-inertia": (11,), "hard": (11,)}
"""Suites, and the seeds of their scenarios."""
LEAN = "linear:60,240"
"""Ramp [r/min] to save injection from, corners at nodes of the grid."""
SHARED = {"margin": 0.05, "smoothness": 1.0, "eval_freq": 1_000_000, "validate_size": 2048}
"""Settings of every training: exploration beyond the band of Eq. 25, and a coarse grid."""
Stage = tuple[float, Mapping[str, Any]]
"""Share of a training, and its settings."""


@dataclass(frozen=True)
class Case:
    """One question to learning."""

    estimator: str
    train: Mapping[str, Any]
    ripple_weight: float
    """In validation, of schedules and of rules with gains"""
    stages: Sequence[Stage]
    """First what loses lock, then all else"""
    steps: int
    """Decisions of a training"""
    beside: Sequence[str]
    """Other policies to judge"""
    gains: Mapping[str, Sequence[float]] = field(default_factory=dict)
    """Rules that set gains too, to be tuned, by name: speeds of ``tune_with_gains``"""
    start: str = "eq25"
    """Schedule that training starts from"""
    rule: str = "logistic-tuned"
    """Rule that those with gains start from; tuned before, in 50,000 simulated seconds"""
    losses: Sequence[str] = ()
    """Suites whose share of lost scenarios counts in tuning and validation, too"""


CASES = {
    "smo-ks": Case(
        "smo",
        {"axes": "start", "outlier": 10.0, "eval_freq": 250_000, "clip_range": 0.4, "n_epochs": 5},
        1.0,
        (
            (0.5, {"hard": 0.03, "lr_nodes": 0.02, "noise": 0.12, "smoothness": 0.7}),
            (0.5, {"hard": 0.03, "lr_nodes": 0.02, "lr_end": 0.2, "noise": 0.06,
                   "smoothness": 0.5}),
        ),
        2_000_000,
        ("eq25", "logistic-tuned"),
        start="logistic-tuned",
    ),
    "smo-gains": Case(
        "smo",
        {
            "gains": "observer,injection,l_q,amplitude:0.5:1.5",
            "axes": "start", "hard": 0.15, "outlier": 10.0, "ripple_cost": 0.09,
            "speed_cost": 0.03, "lr_nodes": 0.04, "lr_end": 0.1,
        },
        4.0,
        ((1.0, {}),),
        10_000_000,
        ("eq25", "logistic-tuned", "tuned-smo-gains"),
        {"static": STATIC, "scheduled": SCHEDULED},
        "tuned-smo-gains",
    ),
    "smo-robust": Case(
        "smo",
        {
            "gains": "observer,injection,l_q,amplitude:0.5:1.5",
            "axes": "start", "hard": 0.15, "low_inertia": 0.25, "mismatch": 0.15,
            "outlier": 30.0, "ripple_cost": 0.25, "speed_cost": 0.03, "lr_nodes": 0.04,
            "lr_end": 0.1, "eval_freq": 10**9, "last": True, "validate_size": 512,
        },
        4.0,
        ((1.0, {}),),
        5_000_000,
        ("eq25", "tuned-smo-gains", "ppo-smo-gains"),
        {"scheduled": SCHEDULED},
        "tuned-smo-robust",
        losses=("low-inertia", "hard-train"),
    ),
    "coupled": Case(
        "coupled",
        {
            "axes": "speed:0:0.96:25",
            "gains": "observer:0.75:1.3,injection:0.5:1.5,l_q:0.95:1.06", "hard": 0.05,
            "outlier": 10.0, "n_envs": 128, "n_epochs": 5, "ripple_cost": 0.010,
            "injection_cost": 0.0012, "margin": 0.5, "eval_freq": 10**9, "last": True,
            "validate_size": 512,
        },
        2.0,
        ((1.0, {"lr_nodes": 0.03, "lr_end": 0.1, "noise": 0.08, "smoothness": 3.0}),),
        2_000_000,
        ("eq25", "tuned-coupled", LEAN),
        {"static": STATIC, "scheduled": SCHEDULED},
        LEAN,
        "logistic-coupled-tuned",
    ),
}  # fmt: skip
"""``coupled`` is asked for less injection, ``smo-robust`` for fewer losses where many are lost.
Validation in training counts neither, so their last tables count."""


def trained(
    name: str, case: Case, seed: int, factory: SimFactory, work: Path, steps: int
) -> Policy:
    """Schedule of one seed of PPO from the start of its case."""
    start, axes = case.start, case.train["axes"]
    for i, (share, stage) in enumerate(case.stages):
        run = work / f"{name}-seed-{seed}-{i}"
        config = TrainConfig(
            **{**SHARED, **case.train, **stage, "axes": axes}, start=start, seed=seed,
            steps=round(share * steps), ripple_weight=case.ripple_weight,
        )  # fmt: skip
        if not (run / "done").is_file():
            shutil.rmtree(run, ignore_errors=True)  # a training that was interrupted starts again
            train(config, factory.design, run, table_named(start, factory.motor))
            write_atomic(run / "done", "")
        start, axes = str(run), "start"
    return load_run(run, factory.motor)


def tuned(
    name: str, kind: str, case: Case, seed: int, factory: SimFactory, work: Path, budget: float
) -> Policy:
    """Rule of one seed of CMA-ES with one kind of the gains of the case."""
    motor, path = factory.motor, work / f"{name}-{kind}-{seed}.json"
    if not path.is_file():
        ranges = TrainConfig(**case.train).gain_ranges
        start = Tuned.load(tuned_file(case.rule)).parameters
        given = factory, ranges, case.gains[kind], budget, seed, case.ripple_weight, start
        table, value = tune_with_gains(*given, case.losses)
        origin = {**Machines.of(motor, 0, seed).origin(), **record(factory.design, motor)}
        facts = {"rule": "logistic", "gains over speed": list(case.gains[kind]), "seed": seed}
        table.save(path, {**origin, **facts, "budget_s": budget, "judged": value})
    return load_table(path, motor)


def validated(
    policies: Mapping[int, Policy], factory: SimFactory, case: Case, size: int
) -> dict[int, float]:
    """Objective of each policy in validation, by its seed."""
    out = {}
    for seed, policy in policies.items():
        value = validate(policy, factory, size).weighted(case.ripple_weight)
        for name in case.losses:
            rows = SuiteRows(name, factory.motor, 0, size, "tune")
            value += LOST_BESIDE * float((score(policy, rows, factory).lost != 0).mean())
        out[seed] = round(value, 5)
    return out


def judge(
    policies: Mapping[str, Policy],
    agents: Sequence[str],
    factory: SimFactory,
    suites: Sequence[str],
    size: int,
) -> dict[str, Any]:
    """Every policy on every suite, and the agents against each of the others."""
    out: dict[str, Any] = {}
    for suite in suites:
        for seed in JUDGED[suite]:
            rows = SuiteRows(suite, factory.motor, seed, size)
            found = {name: score(p, rows, factory) for name, p in policies.items()}
            ours = [found[name] for name in agents]
            against = {
                name: {metric: change_over_seeds(ours, s, metric) for metric in NAMES}
                for name, s in found.items()
                if name not in agents
            }
            table = {name: survived(s, NAMES) for name, s in found.items()}
            out[f"{suite}:{seed}"] = {"policies": table, "agents against": against}
            print(f"{suite}:{seed}", json.dumps(out[f"{suite}:{seed}"], indent=1), flush=True)
    return out


def study(name: str, words: argparse.Namespace) -> dict[str, Any]:
    """Train, tune, pick and judge one case."""
    case = CASES[name]
    factory = SimFactory(Motor.load("paper"), DriveDesign(estimator=case.estimator))
    words.work.mkdir(parents=True, exist_ok=True)
    steps = words.steps or case.steps
    agents = {s: trained(name, case, s, factory, words.work, steps) for s in words.seeds}
    policies = {word: make_policy(word, factory.motor) for word in case.beside}
    values = {"ppo": validated(agents, factory, case, words.validate)}
    if case.gains:
        shipped = {0: make_policy(f"tuned-{name}", factory.motor)}
        values["shipped"] = validated(shipped, factory, case, words.validate)
    for kind in case.gains:
        rules = {
            s: tuned(name, kind, case, s, factory, words.work, words.budget)
            for s in words.rule_seeds
        }
        values[kind] = validated(rules, factory, case, words.validate)
        policies[kind] = rules[least(values[kind])]
    policies |= {f"ppo seed {s}": p for s, p in agents.items()}
    names = [f"ppo seed {s}" for s in agents]
    found = judge(policies, names, factory, words.suites, words.size)
    asked = {"command": " ".join(("python", *sys.argv)), "steps": steps,
             "budget_s": words.budget, "size": words.size}  # fmt: skip
    settings = {"train": {**SHARED, **case.train}, "stages": case.stages}
    return {**asked, "estimator": case.estimator, **settings, "validated": values,
            "judged": found, "versions": versions()}  # fmt: skip


def least(values: Mapping[int, float]) -> int:
    """Seed with the least objective."""
    return min(values, key=lambda seed: values[seed])


def publish(name: str, found: Mapping[str, Any], work: Path) -> None:
    """Ship the best agent, and the best rule with gains if it is better than the one shipped."""
    values = dict(found["validated"])
    last = len(CASES[name].stages) - 1
    source = {f"ppo-{name}": work / f"{name}-seed-{least(values.pop('ppo'))}-{last}/table.json"}
    if values:
        kind = min(values, key=lambda kind: min(values[kind].values()))
        if kind != "shipped":
            policy = f"tuned-{name}" + ("-gains" if f"tuned-{name}" in ALIASES else "")
            source[policy] = work / f"{name}-{kind}-{least(values[kind])}.json"
    for policy, path in source.items():
        to = FOLDER / "learned" / f"{policy}.json"
        to.parent.mkdir(exist_ok=True)
        table = KsTable.load(path)
        table.save(to, {**table.provenance, "command": found["command"]})


def main() -> None:
    """Run one case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=list(CASES))
    parser.add_argument("--seeds", type=a_seed, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--rule-seeds", type=a_seed, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--steps", type=int, default=0, help="decisions of a training; 0: its own")
    parser.add_argument("--budget", type=float, default=20_000.0, help="simulated s of a tuning")
    parser.add_argument(
        "--validate", type=a_count, default=8192, help="scenarios to pick the best on"
    )
    parser.add_argument(
        "--size", type=a_count, default=2000, help="scenarios of a suite to judge on"
    )
    parser.add_argument("--suites", nargs="+", choices=list(JUDGED), default=list(JUDGED))
    parser.add_argument("--work", type=Path, default=Path("build/learning"))
    parser.add_argument("--out", type=Path, default=Path("results/studies/learning.json"))
    parser.add_argument("--publish", action="store_true", help="ship the best by their names")
    words = parser.parse_args()
    check_writable(words.out)
    found = study(words.case, words)
    known = json.loads(words.out.read_text(encoding="utf-8")) if words.out.is_file() else {}
    write_record(words.out, {**known, words.case: found})
    if words.publish:
        publish(words.case, found, words.work)


if __name__ == "__main__":
    in_one_line(main)

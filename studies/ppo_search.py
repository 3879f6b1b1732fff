"""Hyperparameters of the training by a recorded search (Optuna's TPE).

    python studies/ppo_search.py --trials 60 --steps 2000000

Every trial trains each seed for the same number of decisions; its score is the mean objective of
the best tables on scenarios that neither training nor validation used. All trials are in the
journal: rerun the command to resume; several processes may share one journal. The summary lists
them, best first. Needs the extra ``tune``.
"""

import argparse
import json
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend

from sensorless.agents.loading import load_run
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import in_one_line
from sensorless.evaluation.validation import validate
from sensorless.files import check_writable, ensure_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.versions import versions

JUDGED = 2
"""Seed of the scenarios that trials are judged on; validation in training uses 0."""

SEARCHED = (
    "n_steps", "n_epochs", "batch_size", "lr_nodes", "lr_critic", "noise",
    "smoothness", "average", "lost_penalty", "angle_cost", "lr_end",
)  # fmt: skip
"""Fields of ``TrainConfig``; gamma goes by its horizon."""


def suggested(trial: optuna.Trial, base: TrainConfig) -> TrainConfig:
    """Settings of a trial."""
    horizon_ms = trial.suggest_float("horizon_ms", 500.0, 20_000.0, log=True)
    return replace(
        base,
        gamma=1.0 - base.decision_ms / horizon_ms,
        n_steps=trial.suggest_categorical("n_steps", [100, 200, 400]),
        n_epochs=trial.suggest_int("n_epochs", 1, 6),
        batch_size=trial.suggest_categorical("batch_size", [6400, 12800, 25600]),
        lr_nodes=trial.suggest_float("lr_nodes", 1e-3, 4e-2, log=True),
        lr_critic=trial.suggest_float("lr_critic", 2e-4, 4e-3, log=True),
        noise=trial.suggest_float("noise", 0.03, 0.2, log=True),
        smoothness=trial.suggest_float("smoothness", 0.0, 4.0),
        average=trial.suggest_categorical("average", [5, 10, 20]),
        lost_penalty=trial.suggest_float("lost_penalty", 300.0, 3000.0, log=True),
        angle_cost=trial.suggest_categorical("angle_cost", [0.0, 0.3, 1.0, 3.0]),
        lr_end=trial.suggest_categorical("lr_end", [1.0, 0.3, 0.05]),
    )


def worth(
    base: TrainConfig, seeds: list[int], size: int, factory: SimFactory
) -> Callable[[optuna.Trial], float]:
    """Objective of the search."""

    def objective(trial: optuna.Trial) -> float:
        config = suggested(trial, base)
        found = []
        start = table_named(config.start, factory.motor)
        for seed in seeds:
            with tempfile.TemporaryDirectory() as folder:
                run = Path(folder) / "run"
                train(replace(config, seed=seed), factory.design, run, start)
                found.append(validate(load_run(run, factory.motor), factory, size, JUDGED))
        for name in ("lost_rate", "torque_dev", "torque_ripple"):
            trial.set_user_attr(name, [getattr(cost, name) for cost in found])
        return float(np.mean([cost.objective for cost in found]))

    return objective


def summary(study: optuna.Study, asked: dict[str, Any]) -> str:
    """All finished trials, best first, as JSON."""
    trials = [t for t in study.trials if t.state is optuna.trial.TrialState.COMPLETE]
    rows = [
        {"number": t.number, "objective": t.value, **t.user_attrs, "settings": t.params}
        for t in sorted(trials, key=lambda t: (t.value, t.number))
    ]
    facts = {**asked, "versions": {**versions(), "optuna": optuna.__version__}}
    return json.dumps({**facts, "trials": rows}) + "\n"


def main() -> None:
    """Search until the journal has enough finished trials."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=a_count, default=60, help="finished trials wanted in all")
    parser.add_argument("--steps", type=int, default=2_000_000, help="decisions of a run")
    parser.add_argument("--seeds", type=a_seed, nargs="+", default=[1, 2])
    parser.add_argument("--size", type=a_count, default=1000, help="scenarios to judge on")
    parser.add_argument("--motor", default="paper")
    parser.add_argument("--estimator", default="smo", help="of the drive: smo or flux")
    parser.add_argument("--axes", default=TrainConfig.axes)
    parser.add_argument("--start", default=TrainConfig.start)
    parser.add_argument("--out", type=Path, default=Path("results/studies/ppo_search.json"))
    args = parser.parse_args()
    ensure_writable(args.out.parent)
    check_writable(args.out)
    asked = {k: v for k, v in vars(args).items() if k not in ("out", "trials")}
    storage = JournalStorage(JournalFileBackend(str(args.out.with_suffix(".journal"))))
    name = json.dumps(asked, sort_keys=True)  # other words, another study in the same journal
    study = optuna.create_study(storage=storage, study_name=name, load_if_exists=True)
    study.sampler = optuna.samplers.TPESampler(seed=len(study.trials), multivariate=True)
    if not study.trials:
        chosen = TrainConfig(steps=args.steps)
        start = {key: getattr(chosen, key) for key in SEARCHED}
        study.enqueue_trial({**start, "horizon_ms": chosen.decision_ms / (1.0 - chosen.gamma)})
    factory = SimFactory(Motor.load(args.motor), DriveDesign(estimator=args.estimator))
    base = TrainConfig(motor=args.motor, steps=args.steps, axes=args.axes, start=args.start)
    objective = worth(base, args.seeds, args.size, factory)

    def write(study: optuna.Study, trial: object) -> None:
        write_atomic(args.out, summary(study, asked))

    done = sum(t.state is optuna.trial.TrialState.COMPLETE for t in study.trials)
    study.optimize(objective, n_trials=max(args.trials - done, 0), callbacks=[write])
    write(study, None)
    print(f"best: {study.best_value:.4f} with {study.best_params}\nwrote {args.out}")


if __name__ == "__main__":
    in_one_line(main)

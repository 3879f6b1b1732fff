"""PPO (stable-baselines3) on the schedule table."""

import dataclasses
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure

from sensorless.agents.run_folder import CONFIG, LATEST, create, reopen, save_table
from sensorless.agents.sb3_adapter import SB3VecEnv
from sensorless.agents.table_policy import TableActorCritic
from sensorless.agents.train_config import TrainConfig
from sensorless.agents.validation import validate
from sensorless.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenario import Scenarios, SimFactory
from sensorless.envs.stress import stress_scenarios
from sensorless.errors import UserError
from sensorless.ks_table import KsTable
from sensorless.motor import Motor
from sensorless.objective import Cost
from sensorless.suites import ROLES

VALUE_SCALE = 20.0
"""Size of a usual return, about half of the penalty for lost lock."""

Progress = Callable[[float, int, Cost | None], None]
"""Called with the share done, the decisions made, and a new validation if there is one."""


class TablePPO(PPO):
    """PPO that leaves the learning rates to the policy's own two parameter groups."""

    def _update_learning_rate(self, optimizers: Any) -> None:
        """Keep what ``TableActorCritic`` set."""


class TrainingScenarios:
    """Stress scenarios with the role ``train``; the first of each environment is cut short.

    Cutting puts the environments out of step with each other, so that every rollout sees starts,
    middles and ends.
    """

    def __init__(self) -> None:
        self._first = True

    def __call__(self, motor: Motor, seeds: Seeds) -> Scenarios:
        """Scenarios of these seeds."""
        s = stress_scenarios(motor, combine(ROLES["train"], seeds))
        if self._first:
            self._first = False
            share = combine(seeds, 0).astype(np.float64) * 2.0**-64
            s.duration = s.duration * (0.05 + 0.95 * share)
        return s


class Watch(BaseCallback):
    """Ends the training in time, validates, and keeps checkpoint and best table on disk."""

    def __init__(
        self, folder: Path, config: TrainConfig, factory: SimFactory, report: Progress | None
    ) -> None:
        super().__init__()
        self._folder, self._config, self._factory, self._report = folder, config, factory, report
        self._facts: dict[str, Any] = json.loads((folder / CONFIG).read_text(encoding="utf-8"))
        self._start = self._last = time.monotonic()
        self._updates = 0
        self._first_step = 0
        self.best: tuple[Cost, KsTable] | None = None

    def _on_training_start(self) -> None:
        self._first_step = self.model.num_timesteps

    def _on_step(self) -> bool:
        return self.share < 1.0

    @property
    def share(self) -> float:
        """Part of the budget that is used up."""
        done = self.model.num_timesteps - self._first_step
        seconds = time.monotonic() - self._start
        return max(seconds / max(60.0 * self._config.minutes, 1e-9), done / self._config.steps)

    def _on_rollout_start(self) -> None:
        policy: Any = self.model.policy
        policy.learn_nodes = self._updates >= self._config.warm_up
        self._updates += 1
        due = time.monotonic() - self._last >= self._config.validate_seconds
        if self.best is None or due:
            self.judge()
        elif self._report is not None:
            self._report(min(self.share, 1.0), self.model.num_timesteps, None)

    def judge(self) -> None:
        """Validate the table as it stands, keep it if it is the best, and save a checkpoint."""
        table = self.model.policy.actor.table()  # type: ignore[operator, union-attr]
        found = validate(table, self._factory, self._config.validate_size)
        for name, value in dataclasses.asdict(found).items():
            self.logger.record(f"validation/{name}", value)
        self.logger.record("validation/objective", found.objective)
        if self.best is None or found.objective < self.best[0].objective:
            self.best = (found, table)
            facts = {"steps": self.model.num_timesteps, "validation": dataclasses.asdict(found)}
            save_table(self._folder, table, self._facts, **facts)
        self.checkpoint()
        if self._report is not None:
            self._report(min(self.share, 1.0), self.model.num_timesteps, found)
        self._last = time.monotonic()

    def checkpoint(self) -> None:
        """Save model and optimiser, whole or not at all."""
        part = self._folder / "checkpoints" / "part.zip"
        self.model.save(part)
        part.replace(self._folder / LATEST)


def train(
    config: TrainConfig,
    design: DriveDesign,
    folder: Path,
    *,
    resume: bool = False,
    report: Progress | None = None,
) -> Cost:
    """Train into a run folder; returns what the best table reached in validation.

    A run that is resumed goes on counting its steps with the same settings but for ``minutes`` and
    ``steps``; it is not bit-identical to one that was never interrupted, because the environments
    begin new episodes.

    Raises
    ------
    UserError
        A setting out of range, a folder in use, or a checkpoint of another motor.
    KeyboardInterrupt
        After checkpoint and best table were saved.
    """
    torch.set_num_threads(1)
    motor = Motor.load(config.motor)
    if resume:
        old, design, digest = reopen(folder)
        if config.motor == TrainConfig.motor:
            motor = Motor.load(old.motor)
        if digest != motor.digest:
            raise UserError(
                f"resume: {str(folder)!r} was trained on motor {old.motor!r}, digest "
                f"{digest[:16]}; allowed: motor {motor.name!r}, digest {motor.digest[:16]}"
            )
        config = dataclasses.replace(old, minutes=config.minutes, steps=config.steps)
    table = config.start_table(motor, design.k_s_slew)
    if not resume:
        create(folder, config, motor, design)
    model = _model(config, design, motor, table, folder if resume else None)
    model.set_logger(configure(str(folder / "tb"), ["tensorboard", "csv"]))
    watch = Watch(folder, config, SimFactory(motor, design), report)
    try:
        model.learn(10**15, callback=watch, log_interval=1, reset_num_timesteps=not resume)
        watch.judge()
    except KeyboardInterrupt:
        watch.checkpoint()
        raise
    finally:
        model.logger.close()
    assert watch.best is not None
    return watch.best[0]


def _model(
    config: TrainConfig, design: DriveDesign, motor: Motor, table: KsTable, resume: Path | None
) -> TablePPO:
    env = SB3VecEnv(
        BlendVectorEnv(
            config.n_envs,
            autoreset_mode="SameStep",
            motor=motor,
            design=design,
            decision_period=1e-3 * config.decision_ms,
            scenarios=TrainingScenarios(),
            weights=RewardWeights(lost=config.lost_penalty),
        ),
        privileged=True,
    )
    if resume is not None:
        model = TablePPO.load(resume / LATEST, env=env, device="cpu")
        env.seed(config.seed + 1 + model.num_timesteps)
        return model
    torch.manual_seed(config.seed)
    return TablePPO(
        TableActorCritic,
        env,
        learning_rate=config.lr_critic,
        n_steps=config.n_steps,
        batch_size=config.batch_size,
        n_epochs=config.n_epochs,
        gamma=config.gamma,
        gae_lambda=config.gae_lambda,
        clip_range=config.clip_range,
        max_grad_norm=1e9,
        vf_coef=0.5 / VALUE_SCALE**2,
        use_sde=True,
        seed=config.seed,
        device="cpu",
        policy_kwargs={
            "table": table,
            "lr_nodes": config.lr_nodes,
            "noise": config.noise,
            "smoothness": config.smoothness,
            "value_scale": VALUE_SCALE,
            "hidden": 64,
        },
    )

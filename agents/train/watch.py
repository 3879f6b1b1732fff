"""What happens beside the updates of PPO: validation, best schedule, checkpoints and the end."""

import dataclasses
import json
import math
import time
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback
from torch import Tensor

from sensorless.agents.loading import CONFIG, MLP, TABLE, load_run, provenance
from sensorless.agents.mlp.policy import MlpActorCritic
from sensorless.agents.pairs import restart
from sensorless.agents.table.policy import TableActorCritic
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import rows, write_rows
from sensorless.agents.train.env import stream
from sensorless.agents.train.run_folder import LATEST, save_schedule
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import DURATION
from sensorless.errors import UserError, shown
from sensorless.evaluation.objective import Cost
from sensorless.evaluation.validation import validate_all
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor

Progress = Callable[[float, int, Cost | None], None]
"""Called with the share done, the decisions so far, and the cost in a new validation if any."""


class Watch(BaseCallback):
    """Ends the training in time, validates, and writes checkpoint and best schedule.

    It validates a running mean of the actor, in which an update has the weight 1 over
    ``config.average`` (a plain mean until there are as many), and keeps the best such mean, or the
    last one if the run asks for that: the optimiser takes steps even where the gradient is nothing
    but noise, and the mean removes most of that.
    """

    def __init__(
        self,
        folder: Path,
        config: TrainConfig,
        factories: Sequence[SimFactory],
        report: Progress | None,
    ) -> None:
        super().__init__()
        self._folder, self._config, self._report = folder, config, report
        self._factories = factories
        self._facts: dict[str, Any] = json.loads((folder / CONFIG).read_text(encoding="utf-8"))
        self._start = time.monotonic()
        self._updates, self._judged = 0, -1
        decision = 1e-3 * config.decision_ms
        self._rollouts = max(1, math.ceil(DURATION / (config.n_steps * decision) - 1e-9))
        self._first_step = self._last_step = 0
        self._mean: Tensor | None = None
        self._rows = rows(folder)
        self._before = float(self._rows[-1]["seconds"]) if self._rows else 0.0
        self.best = _kept(folder, factories[0].motor)

    def _on_training_start(self) -> None:
        self._first_step = self._last_step = self.model.num_timesteps
        self._steps = self.actor.steps()
        if self._rows and self._rows[-1]["steps"] == self._first_step and self.best is not None:
            self._judged = self._updates  # a resumed run has its row of this actor
        self.judge()

    @property
    def actor(self) -> TableActorCritic | MlpActorCritic:
        """The policy that is trained."""
        policy = self.model.policy
        assert isinstance(policy, TableActorCritic | MlpActorCritic)
        return policy

    def _on_step(self) -> bool:
        return bool(self._config.steps) or self.share < 1.0  # PPO itself counts the steps

    def _on_training_end(self) -> None:
        if self._config.steps:
            self._take_in()

    @property
    def share(self) -> float:
        """Share of the budget that is used."""
        if self._config.steps:
            return (self.model.num_timesteps - self._first_step) / self._config.steps
        return (time.monotonic() - self._start) / max(60.0 * self._config.minutes, 1e-9)

    def _on_rollout_start(self) -> None:
        policy = self.actor
        left = 1.0 - (1.0 - self._config.lr_end) * min(self.share, 1.0)
        for group, whole in zip(policy.optimizer.param_groups, self._steps, strict=True):
            group["lr"] = left * whole
        if self._updates % self._rollouts == 0:
            restart(self.model, stream(self._config.seed, self.model.num_timesteps))
        policy.learn_actor = self.model._n_updates >= self._config.warm_up * self._config.n_epochs
        self._take_in()
        if self.model.num_timesteps - self._last_step >= self._config.eval_freq:
            self.judge()
        elif self._report is not None:
            self._report(min(self.share, 1.0), self.model.num_timesteps, None)

    def _take_in(self) -> None:
        """Take the actor of now into the mean."""
        self._updates += 1
        now = self.actor.vector()
        window = min(self._updates, self._config.average)
        mean = now if self._mean is None else self._mean
        self._mean = mean + (now - mean) / window

    def judge(self) -> None:
        """Validate the mean actor unless it just was, keep the best, and save a checkpoint."""
        if self._judged == self._updates:
            return
        self._judged = self._updates
        policy = self.actor
        schedule = policy.schedule(policy.vector() if self._mean is None else self._mean)
        found = validate_all(schedule, self._factories, self._config.validate_size)
        better = self.best is None or self._score(found) < self._score(self.best)
        keep = better or self._config.last
        if keep:
            self.best = found
            facts = {"steps": self.model.num_timesteps, "validation": dataclasses.asdict(found)}
            save_schedule(self._folder, schedule, self._facts, **facts)
        self._log(found, keep)
        self.checkpoint()
        if self._report is not None:
            self._report(min(self.share, 1.0), self.model.num_timesteps, found)
        self._last_step = self.model.num_timesteps

    def _score(self, cost: Cost) -> float:
        """Objective with the run's own weight of ripple."""
        return cost.weighted(self._config.ripple_weight)

    def _log(self, found: Cost, keep: bool) -> None:
        """Add a row to the learning curve: TensorBoard, and a file that a resumed run continues."""
        values = {**dataclasses.asdict(found), "objective": found.objective}
        for name, value in values.items():
            self.logger.record(f"validation/{name}", value)
        seconds = self._before + time.monotonic() - self._start
        row = {"steps": self.model.num_timesteps, "seconds": f"{seconds:.1f}"}
        self._rows.append({**row, **values, "best": int(keep)})
        write_rows(self._folder, self._rows)

    def checkpoint(self) -> None:
        """Save model and optimiser, whole or not at all.

        Raises
        ------
        UserError
            The disk is full.
        """
        file = BytesIO()
        self.model.save(file)
        write_atomic(self._folder / LATEST, file.getvalue())


def _kept(folder: Path, motor: Motor) -> Cost | None:
    """Validation of the best schedule so far.

    Raises
    ------
    UserError
        Its file does not have it.
    """
    if not any((folder / name).is_file() for name in (TABLE, MLP)):
        return None
    found: Any = provenance(load_run(folder, motor)).get("validation")
    try:
        cost = Cost(**found)
        if not all(math.isfinite(x) for x in dataclasses.astuple(cost)):
            raise ValueError
    except (TypeError, ValueError):
        raise UserError(
            f"{folder}: validation of the schedule: {shown(found)}; restore the file, or train anew"
        ) from None
    return cost

"""Trains a schedule table, or a network in its place, with PPO (stable-baselines3)."""

import dataclasses
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import configure
from stable_baselines3.common.save_util import load_from_zip_file
from torch.optim import Optimizer

from sensorless.agents.mlp.policy import MlpActorCritic
from sensorless.agents.pairs import PairedRolloutBuffer
from sensorless.agents.table.policy import TableActorCritic
from sensorless.agents.train.alone import alone
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import cut_back
from sensorless.agents.train.env import training_env
from sensorless.agents.train.run_folder import LATEST, create, fresh, note_resumed, reopen
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.agents.train.watch import Progress, Watch
from sensorless.design.carried import refuse_settings
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError, shown
from sensorless.evaluation.objective import Cost
from sensorless.files import ensure_writable, sweep
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings
from sensorless.settings import settings_of
from sensorless.table.ks_table import KsTable

VALUE_SCALE = 20.0
"""Size of a typical return, the unit of the critic."""

BUDGET: Mapping[str, Any] = {"minutes": TrainConfig.minutes, "steps": TrainConfig.steps}
"""Settings that a resumed run takes anew, with their defaults."""


class TablePPO(PPO):
    """PPO that leaves the learning rates to the policy's own optimiser."""

    def _update_learning_rate(self, optimizers: list[Optimizer] | Optimizer) -> None:
        """Keep what the policy set."""


def train(
    config: TrainConfig,
    design: DriveDesign,
    folder: Path,
    source: KsTable,
    *,
    report: Progress | None = None,
) -> Cost:
    """Train into a new run folder; return the cost of the best schedule in validation.

    Parameters
    ----------
    config, design
    folder : Path
        New or empty.
    source : KsTable
        The schedule named ``config.start``, which is copied onto the axes of the run.
    report : optional
        Called with the share done, the decisions so far and the cost in a new validation.

    Raises
    ------
    UserError
        A setting is out of range or would not be read, or the folder is in use.
    KeyboardInterrupt
        Raised after checkpoint and best schedule were saved.
    """
    _refuse_unused(config)
    reference = Motor.load(config.motor)
    machines = Machines.of(reference, config.machines, config.seed)
    table = config.start_table(source, reference, design.k_s_slew)
    model = new_model(config, table, training_env(config, design, machines.motors))
    with fresh(folder):
        create(folder, config, machines, design, table)
        return _learn(model, folder, config, design, machines, report)


def resume(
    given: Mapping[str, Any],
    folder: Path,
    *,
    asked: Settings = NO_SETTINGS,
    report: Progress | None = None,
) -> Cost:
    """Continue the run in ``folder`` with its own settings, except ``minutes`` and ``steps``.

    The counts of steps and updates continue, but the result is not bit-identical to an
    uninterrupted run, because the environments begin new episodes.

    Parameters
    ----------
    given : mapping of str to object
        ``minutes`` or ``steps`` from here on, and other settings of `TrainConfig` that the run
        must have.
    folder : Path
    asked : mapping of str to object
        Settings of the drive that the run must have.
    report : optional
        As in `train`, as are result and errors.

    Raises
    ------
    UserError
        The folder has no run or is in use, its checkpoint is damaged or belongs to another motor,
        or the run has other settings than those ``given`` or ``asked`` for.
    """
    old, known, table = reopen(folder)
    refuse_settings(known.settings, asked, str(folder), known.motor, "train anew")
    _refuse_given(old, given, folder)
    design = DriveDesign(**known.settings)
    motor = None if "motor" in given else known.motor
    motor = motor or Motor.load(given.get("motor", old.motor))
    machines = Machines.of(motor, old.machines, old.seed)
    name, digest = known.made_for or ("?", "")
    if digest != machines.digest:
        raise UserError(
            f"resume: {str(folder)!r} was trained on {name!r}, digest {digest[:16]}; "
            f"it cannot continue on {machines.name!r}, digest {machines.digest[:16]}; leave "
            "--motor out, or give that machine"
        )
    config = dataclasses.replace(old, **{name: given.get(name, BUDGET[name]) for name in BUDGET})
    ensure_writable(folder)
    with alone(folder):
        model = new_model(config, table, training_env(config, design, machines.motors))
        sweep(folder)
        sweep(folder / "checkpoints")
        if (folder / LATEST).is_file():  # else the run ended before its first checkpoint
            _restore(model, folder / LATEST)
        cut_back(folder, model.num_timesteps)
        note_resumed(folder, model.num_timesteps)
        return _learn(model, folder, config, design, machines, report)


def _refuse_given(run: TrainConfig, given: Mapping[str, Any], folder: Path) -> None:
    """Refuse a setting that the run was not started with; `resume` judges motors by digest."""
    for name, value in given.items():
        own = getattr(run, name)
        if name not in (*BUDGET, "motor") and value != own:
            raise UserError(
                f"{name}: {shown(value)}: {str(folder)!r} was started with {shown(own)}; leave "
                f"--{name.replace('_', '-')} out, or start a new run with --name"
            )


def _learn(
    model: TablePPO,
    folder: Path,
    config: TrainConfig,
    design: DriveDesign,
    machines: Machines,
    report: Progress | None,
) -> Cost:
    model.set_logger(configure(str(folder / "tb"), ["tensorboard"]))
    factories = [SimFactory(motor, design) for motor in machines.motors]
    watch = Watch(folder, config, factories, report)
    try:
        steps = config.steps or 10**15
        model.learn(steps, callback=watch, log_interval=1, reset_num_timesteps=False)
        watch.judge()
    except KeyboardInterrupt:
        watch.checkpoint()
        raise
    finally:
        model.logger.close()
    assert watch.best is not None
    return watch.best


def _refuse_unused(config: TrainConfig) -> None:
    """Refuse settings that nothing in the run would read."""
    unused = {} if config.gains else {"ripple_cost": "training with --gains"}
    if config.policy_kind != "table":
        names = "lr_nodes", "smoothness", "margin"
        unused |= dict.fromkeys(names, "a table: --policy-kind table")
    for name, reader in unused.items():
        value = getattr(config, name)
        if value != settings_of(TrainConfig)[name].default:
            raise UserError(f"{name}: {value:g}: only for {reader}; leave it out")


def new_model(config: TrainConfig, table: KsTable, env: SB3VecEnv) -> TablePPO:
    """PPO of a run before its first update."""
    torch.set_num_threads(1)
    actor: type[TableActorCritic] | type[MlpActorCritic] = TableActorCritic
    kwargs = {"table": table, "noise": config.noise, "value_scale": VALUE_SCALE, "hidden": 64}
    if config.policy_kind == "table":
        kwargs |= {
            "lr_nodes": config.lr_nodes,
            "smoothness": config.smoothness,
            "margin": config.margin,
        }
    else:
        actor = MlpActorCritic
    return TablePPO(
        actor,
        env,
        learning_rate=config.lr_critic,
        n_steps=config.n_steps,
        batch_size=min(config.batch_size, config.n_envs * config.n_steps),
        n_epochs=config.n_epochs,
        gamma=config.gamma,
        gae_lambda=config.gae_lambda,
        clip_range=config.clip_range,
        max_grad_norm=1e9,
        vf_coef=0.5 / VALUE_SCALE**2,
        use_sde=True,
        rollout_buffer_class=PairedRolloutBuffer,
        rollout_buffer_kwargs={"outlier": config.outlier},
        seed=config.seed,
        device="cpu",
        policy_kwargs=kwargs,
    )


def _sound(model: TablePPO) -> bool:
    """Whether all weights and moments are finite, and Adam's second moments not negative."""
    moments = [x for state in model.policy.optimizer.state.values() for x in state.items()]
    least = [x for name, x in moments if name == "exp_avg_sq"]
    numbers = (*model.policy.state_dict().values(), *(x for _, x in moments))
    return all(bool(x.isfinite().all()) for x in numbers) and all(
        bool((x >= 0.0).all()) for x in least
    )


def _restore(model: TablePPO, path: Path) -> None:
    """Load weights, optimiser and counters of a checkpoint; nothing is unpickled.

    Raises
    ------
    UserError
        The checkpoint is damaged or belongs to another table.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            known = json.loads(archive.read("data"))
        _, parameters, _ = load_from_zip_file(path, load_data=False, device="cpu")
        model.set_parameters(parameters, exact_match=True, device="cpu")
        model.num_timesteps = int(known["num_timesteps"])
        model._n_updates = int(known["_n_updates"])
        if not _sound(model):
            raise ValueError(
                "a weight or a moment of the optimiser is no number that training leaves"
            )
    except UnpicklingError:  # of torch, whose own text is on settings that nobody has here
        raise UserError(f"{path}: damaged; restore this run's checkpoint, or train anew") from None
    except Exception as error:  # torch has one of its own for every way to be damaged
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UserError(f"{path}: {reason}; restore this run's checkpoint, or train anew") from None

"""The command ``sensorless train``: every field of ``TrainConfig`` is an option."""

import inspect
import json
import os
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sensorless.agents.train.config import TrainConfig
from sensorless.cli.given import was_given
from sensorless.cli.options import (
    JsonOption,
    SetOption,
    describe,
    errors,
    minutely,
    say_if_unsuited,
    say_json,
    say_verdict,
    say_wrote,
    search_progress,
)
from sensorless.errors import UserError, has_control, shown
from sensorless.settings import settings_of

if TYPE_CHECKING:
    from sensorless.policy import Settings

RUNS = Path("runs")


def with_options(cls: type, function: Callable[..., None]) -> Callable[..., None]:
    """``function`` with one keyword option for every setting of a dataclass behind its own."""
    own = inspect.signature(function)
    fixed = [p for p in own.parameters.values() if p.kind is not p.VAR_KEYWORD]
    extra = [
        inspect.Parameter(
            name,
            inspect.Parameter.KEYWORD_ONLY,
            default=setting.default,
            annotation=Annotated[setting.kind, typer.Option(help=setting.sentence)],
        )
        for name, setting in settings_of(cls).items()
    ]
    function.__signature__ = inspect.Signature([*fixed, *extra])  # type: ignore[attr-defined]
    function.__annotations__ = {p.name: p.annotation for p in [*fixed, *extra]}
    return function


def _train(
    *,
    context: typer.Context,
    name: Annotated[
        str | None,
        typer.Option(
            help="Write the run to this new folder below runs/. Default: none; give --name or "
            "--resume."
        ),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Resume the run in this folder. Default: start a new run."
        ),
    ] = None,
    settings: SetOption = None,
    as_json: JsonOption = False,
    **fields: Any,
) -> None:
    """Train a schedule for k_s with PPO, a method of reinforcement learning.

    The table itself is the policy. It starts as a copy of Eq. 25, the linear rule of the source
    paper, and learns on scenarios of the suite stress-1 that evaluation never uses. The run folder,
    runs/NAME, holds the best schedule found in validation (table.json, or mlp.npz with
    --policy-kind mlp), config.json (settings, command, versions, seed), start.json, checkpoints,
    progress.csv, TensorBoard logs in tb/, and verdict.json: whether the schedule is better than its
    start on 400 scenarios of stress-1 that training has not seen, which the last line says. Every
    --policy option takes the folder.

    The same --seed and --steps give the same schedule to the bit on the same computer; --minutes
    does not. Ctrl-C keeps a checkpoint, and --resume FOLDER continues from it with the settings
    of the run: --minutes and --steps count from there, and other options must agree with it. The
    result is not bit-identical to an uninterrupted run.

    For example:

        sensorless train --name first --minutes 5
        sensorless tune linear --out linear.json
        sensorless train --name better --start linear.json --axes speed:16
    """
    from sensorless.agents.loading import VERDICT
    from sensorless.design.words import asked_for

    if (name is None) == (resume is None):
        raise UserError(
            "name, resume: give one of the two, --name NEW to start a run or --resume FOLDER to "
            "continue one"
        )
    folder = existing(resume) if resume is not None else named_run(str(name))
    given = {k: v for k, v in fields.items() if was_given(context, k)}
    config = TrainConfig(**fields)
    if given.get("steps") and given.get("minutes"):
        raise UserError(
            f"steps, minutes: {config.steps} and {config.minutes:g}: give one of the two: a run "
            "of --steps takes whatever time that takes"
        )
    samples = config.n_envs * config.n_steps
    if given.get("batch_size", 0) > samples:
        raise UserError(
            f"batch_size: {config.batch_size}: an update has {samples} samples, n_envs times "
            "n_steps; give at most that"
        )
    run_training(config, asked_for(settings), folder, resume=None if resume is None else given)
    if as_json:
        say_json(json.loads((folder / VERDICT).read_text(encoding="utf-8")))


def existing(folder: Path) -> Path:
    """Return the folder of a run to resume.

    Raises
    ------
    UserError
        It does not exist.
    """
    if not folder.is_dir():
        near = RUNS / folder
        hint = f"did you mean {near}?" if near.is_dir() else "give a training run's folder"
        raise UserError(f"resume: there is no folder {str(folder)!r}; {hint}")
    return folder


def named_run(name: str) -> Path:
    """Folder of a run below ``RUNS``.

    Raises
    ------
    UserError
        The name leads elsewhere, or has control characters.
    """
    if has_control(name):
        raise UserError(
            f"name: {shown(name)}: has control characters; use letters, digits, - and _"
        )
    path = Path(os.path.normpath(name))
    if not name.strip() or path.is_absolute() or path.parts[:1] in ((), ("..",)):
        raise UserError(f"name: {name!r}: give a name below {RUNS}/, such as first")
    return RUNS / path


def run_training(
    config: TrainConfig,
    asked: "Settings",
    folder: Path,
    *,
    resume: Mapping[str, Any] | None = None,
) -> None:
    """Train with progress on the terminal, and say where the result is.

    With ``resume``, the options that were given, the run in ``folder`` goes on.
    """
    from sensorless.agents.loading import CONFIG
    from sensorless.agents.train import train as training
    from sensorless.agents.train.curve import rows
    from sensorless.agents.train.judge import judge
    from sensorless.design.drive import DriveDesign
    from sensorless.evaluation.objective import Cost
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import table_named

    design = DriveDesign(**asked)
    if resume is None and not config.machines:
        say_if_unsuited(Motor.load(config.motor), design)
    bar = search_progress("training")
    task = bar.add_task("", total=1.0)
    say = minutely()

    def report(done: float, steps: int, found: Cost | None) -> None:
        bar.update(task, completed=done, description=f"{steps / 1e6:.2f} M decisions")
        if found is None:
            say(f"{100 * done:3.0f} %, {steps / 1e6:5.2f} M decisions")
            return
        *before, row = rows(folder)
        mark = ", kept so far" if before and int(row["best"]) else ""
        bar.console.print(
            f"{100 * done:3.0f} %, {steps / 1e6:5.2f} M decisions, validation: "
            f"{describe(vars(found))}{mark}",
            highlight=False,
            soft_wrap=True,
        )

    try:
        with bar:
            if resume is not None:
                training.resume(resume, folder, asked=asked, report=report)
            else:
                source = table_named(config.start, Motor.load(config.motor))
                training.train(config, design, folder, source, report=report)
    except KeyboardInterrupt:
        begun = (folder / CONFIG).is_file()
        errors.print(
            f"interrupted; resume with: sensorless train --resume {shlex.quote(str(folder))}"
            if begun
            else "interrupted before the first decision; nothing was written",
            highlight=False,
            soft_wrap=True,
        )
        raise typer.Exit(130) from None
    say_wrote(folder)
    say_verdict(judge(folder))


train_command = with_options(TrainConfig, _train)

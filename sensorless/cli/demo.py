"""The command ``sensorless demo``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.text import Text

from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    SeedOption,
    console,
    errors,
    policy_progress,
    require_machine,
)
from sensorless.errors import UserError

if TYPE_CHECKING:
    from sensorless.agents.train.config import TrainConfig
    from sensorless.machine.motor import Motor


def demo_command(
    out: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER",
            help="Write everything to this folder: a new one, or that of an earlier demo, which is "
            "replaced.",
        ),
    ] = Path("build/demo"),
    motor: MotorOption = "paper",
    minutes: Annotated[float, typer.Option(help="Train for this long [min].")] = 2.0,
    size: Annotated[
        int,
        typer.Option(
            metavar="N", min=2, help="Judge on this many scenarios of the suite stress-1."
        ),
    ] = 400,
    seed: SeedOption = 7,
    as_json: JsonOption = False,
) -> None:
    """Train, judge, draw and export a schedule for a motor in about three minutes.

    The schedule starts as Eq. 25, the linear rule of the source paper, and learns with PPO. The
    suite stress-1, which draws load, machine and sensor errors at random, judges it beside Eq. 25
    on the paper's observers (sliding_mode), Eq. 25 on the drive that it was trained on (eq25), and
    a drive with a position sensor. Figures, results and C code land in one folder.

    For example:

        sensorless demo --minutes 1 --out build/demo
        sensorless demo --motor mine.toml --out build/mine
    """
    from sensorless.agents.train.config import TrainConfig
    from sensorless.cli.demo_steps import SUITE, fresh_folder
    from sensorless.design.drive import DriveDesign
    from sensorless.envs.scenarios.suites import SuiteRows
    from sensorless.machine.motor import Motor
    from sensorless.plots.figure import require_matplotlib

    if minutes == 0.0:
        raise UserError("minutes: 0: give more than 0")
    machine, config = Motor.load(motor), TrainConfig(motor=motor, minutes=minutes)
    require_machine(machine, DriveDesign())
    SuiteRows(SUITE, machine, seed, size)  # raises where these are no rows of the suite
    require_matplotlib()
    with fresh_folder(out, motor):
        _run(out, machine, config, size, seed, as_json)


def _run(
    out: Path, machine: "Motor", config: "TrainConfig", size: int, seed: int, as_json: bool
) -> None:
    """Train, judge, draw and export in an empty folder."""
    from sensorless.cli.demo_steps import SUITE, draw, hand_over, judge
    from sensorless.cli.train import run_training

    run = out / "ppo-table"
    _step("1/4", f"training a schedule for {config.minutes:g} min, starting from Eq. 25")
    run_training(config, {}, run)
    _step("2/4", f"judging it on {size} scenarios of the suite {SUITE}")
    with policy_progress() as report:
        word = str(run) if run.is_absolute() else f"./{run}"
        results = judge(out, word, machine, size, seed, report)
    _step("3/4", "drawing figures")
    figures = draw(out, str(run), machine, results)
    _step("4/4", "exporting the C code and checking it")
    folder, said = hand_over(out, str(run), machine)
    if as_json:
        typer.echo(results.to_json(scenarios=False))
    console.print(results.table())
    console.print(f"figures:  {', '.join(map(str, figures))}", soft_wrap=True)
    console.print(f"results:  {out / 'results.json'}", soft_wrap=True)
    console.print(f"firmware: {folder} ({said})", soft_wrap=True)


def _step(number: str, text: str) -> None:
    errors.print(Text(number, "bold"), text)

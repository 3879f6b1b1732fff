"""The command ``sensorless``."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from sensorless.cli_distill import distill_command
from sensorless.cli_identify import app as identify_app
from sensorless.cli_pil import pil_command
from sensorless.cli_reproduce import reproduce
from sensorless.cli_train import train_command
from sensorless.cli_tune import list_policies, tune_command
from sensorless.errors import StaleCoreError, UserError

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    help="""Learned hand-over between two position estimators of a sensorless IPMSM drive.

HF injection (HFI) finds the rotor at low speed, a sliding-mode observer (SMO) above; the weight
k_s in [0, 1] blends them (1 = HFI). Train a schedule for k_s, judge it against the rules that
drives ship, and export it as C:

    sensorless train --minutes 5 --name first

    sensorless evaluate --policy eq25 --policy runs/first --suite stress --out results.json

    sensorless export runs/first --out firmware_first
""",
)
console = Console()
errors = Console(stderr=True)

MotorOption = Annotated[str, typer.Option("--motor", help="Shipped motor by name, or a TOML file.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="Drive design, e.g. smo_pll_hz=30; repeatable."
    ),
]
ListOption = Annotated[
    bool, typer.Option("--list", help="Name all policies.", is_eager=True, callback=list_policies)
]
PolicyOption = Annotated[
    list[str],
    typer.Option(
        "--policy",
        help="Rule by name (see evaluate --list), file of sensorless tune, or folder of a training "
        "run; repeatable.",
    ),
]


@app.command()
def simulate(
    motor: MotorOption = "paper",
    policy: Annotated[str, typer.Option(help="As in evaluate.")] = "eq25",
    speed: Annotated[
        str, typer.Option(help="Speed plan TIME:R/MIN,... [s:r/min].")
    ] = "0:200,1:350,2:600",
    load: Annotated[str, typer.Option(help="Load plan TIME:TORQUE,... [s:N m].")] = "0:0",
    ramp: Annotated[
        float | None, typer.Option(help="Slope of the speed reference [r/min/s]; default: steps.")
    ] = None,
    duration: Annotated[float, typer.Option(help="Length [s].")] = 3.0,
    scenario: Annotated[
        str | None,
        typer.Option(
            help="SUITE:SEED:INDEX instead of the plans, e.g. stress:7:12 from a results file."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the measurement noise.")] = 0,
    settings: SetOption = None,
    plot: Annotated[Path | None, typer.Option(help="Waveforms as PNG.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="CSV: every PWM period, or the machine's run.")
    ] = None,
    plant: Annotated[Path | None, typer.Option(help="Machine JSON: run the machine alone.")] = None,
    inputs: Annotated[
        Path | None, typer.Option(help="CSV of u_alpha, u_beta[, tau_L] a period, with --plant.")
    ] = None,
) -> None:
    """Run one drive and look at it, or the machine alone under given voltages.

    Default: Fig. 9 of the source paper (200, 350, 600 r/min without load) under Eq. 25.
    """
    from sensorless.options import check_output

    check_output(plot, "plot")
    check_output(out)
    if plant is not None or inputs is not None:
        from sensorless.plant_io import simulate_plant

        if plant is None or inputs is None or out is None:
            raise UserError("plant: allowed: --plant, --inputs and --out together")
        simulate_plant(plant, inputs, out)
        console.print(f"wrote {out}")
        return
    from sensorless.baselines.registry import make_policy
    from sensorless.motor import Motor
    from sensorless.options import design_from, plan_from, scenario_from
    from sensorless.trace import trace, write_csv
    from sensorless.trace_summary import summary_table

    machine, design = Motor.load(motor), design_from(settings)
    rule = make_policy(policy, machine)
    case = (
        scenario_from(scenario, machine)
        if scenario is not None
        else plan_from(speed, load, ramp, duration, machine, seed)
    )
    run = trace(rule, case, machine, design)
    console.print(summary_table(run, rule.name))
    if out is not None:
        write_csv(run, out)
        console.print(f"wrote {out}")
    if plot is not None:
        from sensorless.plots import save, waveforms

        save(waveforms({f"{machine.name}, {rule.name}, {scenario or 'planned run'}": run}), plot)
        console.print(f"wrote {plot}")


@app.command()
def evaluate(
    policy: PolicyOption,
    motor: MotorOption = "paper",
    suite: Annotated[
        str, typer.Option(help="paper, nominal, handoff, stress, envelope or motors.")
    ] = "stress",
    seed: Annotated[int, typer.Option(min=0, help="Draws the scenarios.")] = 1,
    size: Annotated[int, typer.Option(min=1, help="Number of scenarios.")] = 200,
    settings: SetOption = None,
    out: Annotated[Path | None, typer.Option(help="Results as JSON.")] = None,
    listed: ListOption = False,
) -> None:
    """Judge policies on a suite: lost rates, torque, speed and angle, with 95 % intervals.

    The same suite, seed and size give the same file to the bit. Training and tuning never see these
    scenarios. Every policy is compared with the first one, scenario by scenario.
    """
    from sensorless.evaluate import evaluate as run
    from sensorless.motor import Motor
    from sensorless.options import design_from

    with policy_progress() as report:
        results = run(
            Motor.load(motor),
            design_from(settings),
            suite,
            seed,
            size,
            policy,
            out=out,
            progress=report,
        )
    console.print(results.table())
    if out is not None:
        console.print(f"wrote {out}")


@app.command()
def export(
    run: Annotated[
        str,
        typer.Argument(
            help="Folder of a training run, file of sensorless tune, or a rule with a table: eq25, "
            "linear:LO,HI, smoothstep, fuzzy, constant:K, ..."
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder to write: new, or an earlier export.")],
    motor: MotorOption = "paper",
    settings: SetOption = None,
    fit: Annotated[
        bool, typer.Option("--fit/--no-fit", help="Also fit two speed thresholds to the table.")
    ] = True,
) -> None:
    """Write a schedule and the control core around it as C99, and check the copy.

    The folder holds the table in float32, Q15 and CMSIS-DSP's layout, the core, params.h, golden
    vectors and a Makefile; its self test is compiled and run here if there is a C compiler.
    """
    from sensorless.baselines.registry import make_policy
    from sensorless.export import export as write
    from sensorless.export import table_of
    from sensorless.motor import Motor
    from sensorless.options import design_from

    machine = Motor.load(motor)
    policy = make_policy(run, machine)
    table, design = table_of(policy, run), design_from(settings)
    done = write(table, machine, design, out, policy=policy.name, fit=fit)
    console.print(f"wrote {len(done.files)} files to {done.folder}\n{done.self_test.message}")


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder for all it writes.")] = Path("build/demo"),
    minutes: Annotated[float, typer.Option(help="Time to train [min].")] = 2.0,
    size: Annotated[int, typer.Option(min=2, help="Scenarios to judge on.")] = 400,
    seed: Annotated[int, typer.Option(min=0, help="Of the scenarios to judge on.")] = 7,
) -> None:
    """Train, evaluate, draw and export on the paper's motor, in about three minutes."""
    from sensorless.agents.train_config import TrainConfig
    from sensorless.cli_train import run_training
    from sensorless.demo import draw, fresh_folder, hand_over, judge
    from sensorless.drive import DriveDesign

    config = TrainConfig(minutes=minutes)
    fresh_folder(out)
    run = out / "ppo-table"
    errors.print(f"[bold]1/4[/] training a schedule for {minutes:g} min, starting from Eq. 25")
    run_training(config, DriveDesign(), run, resume=False)
    errors.print(f"[bold]2/4[/] evaluating on {size} stress scenarios")
    with policy_progress() as report:
        results = judge(out, f"./{run}" if not run.is_absolute() else str(run), size, seed, report)
    errors.print("[bold]3/4[/] drawing")
    figures = draw(out, str(run), results)
    errors.print("[bold]4/4[/] exporting and checking the firmware")
    folder, said = hand_over(out, str(run))
    console.print(results.table())
    console.print(f"figures:  {', '.join(map(str, figures))}", soft_wrap=True)
    console.print(f"results:  {out / 'results.json'}", soft_wrap=True)
    console.print(f"firmware: {folder} ({said})", soft_wrap=True)


app.command("train")(train_command)
app.command("distill")(distill_command)
app.command("tune")(tune_command)
app.command("pil")(pil_command)
app.add_typer(identify_app, name="identify")
app.command("reproduce")(reproduce)


@contextmanager
def policy_progress() -> Iterator[Callable[[str, float], None]]:
    """Progress of several policies: bars on a terminal, else a line when one is done."""
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        TimeElapsedColumn(),
        console=errors,
        disable=not errors.is_terminal,
    )
    tasks: dict[str, TaskID] = {}

    def report(name: str, done: float) -> None:
        if name not in tasks:
            tasks[name] = bar.add_task(name, total=1.0)
        bar.update(tasks[name], completed=done)
        if done >= 1.0 and not errors.is_terminal:
            errors.print(f"evaluated {name}", markup=False, highlight=False)

    with bar:
        yield report


def main() -> None:
    """Entry point: a user's mistake is one line and exit status 2, Ctrl-C is status 130."""
    try:
        app(standalone_mode=True)
    except (UserError, StaleCoreError) as error:
        errors.print(f"[bold red]error:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2)
    except KeyboardInterrupt:
        errors.print("interrupted")
        sys.exit(130)
    except BrokenPipeError:
        os._exit(1)

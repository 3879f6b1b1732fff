"""The command ``sensorless``."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from sensorless.cli.distill import distill_command
from sensorless.cli.evaluate import evaluate_command
from sensorless.cli.identify import app as identify_app
from sensorless.cli.options import MotorOption, SetOption, console, errors, policy_progress
from sensorless.cli.pil import pil_command
from sensorless.cli.replay import replay_command
from sensorless.cli.report import report_command
from sensorless.cli.reproduce import reproduce
from sensorless.cli.train import train_command
from sensorless.cli.tune import tune_command
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
            help="SUITE:SEED:INDEX[:SIZE] instead of the plans, as evaluate lists its worst cases, "
            "e.g. stress:7:12; SIZE for envelope only."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the measurement noise.")] = 0,
    start: Annotated[
        bool, typer.Option("--start", help="Angle, polarity and speed unknown: find them first.")
    ] = False,
    theta_err: Annotated[
        float, typer.Option(help="Rotor minus the drive's first angle [deg el.].")
    ] = 0.0,
    spin: Annotated[float, typer.Option(help="Speed of the shaft at first [r/min].")] = 0.0,
    settings: SetOption = None,
    plot: Annotated[Path | None, typer.Option(help="Waveforms as PNG.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="CSV: every PWM period, or the machine's run.")
    ] = None,
    log: Annotated[
        Path | None, typer.Option(help="CSV as a drive would record it, for sensorless replay.")
    ] = None,
    plant: Annotated[Path | None, typer.Option(help="Machine JSON: run the machine alone.")] = None,
    inputs: Annotated[
        Path | None, typer.Option(help="CSV of u_alpha, u_beta[, tau_L] a period, with --plant.")
    ] = None,
) -> None:
    """Run one drive and look at it, or the machine alone under given voltages.

    Default: Fig. 9 of the source paper (200, 350, 600 r/min without load) under Eq. 25.
    """
    from sensorless.files import check_writable

    check_writable(plot, "plot")
    check_writable(out)
    check_writable(log, "log")
    if plant is not None or inputs is not None:
        from sensorless.plant.run import simulate_plant

        if plant is None or inputs is None or out is None:
            raise UserError("plant: allowed: --plant, --inputs and --out together")
        simulate_plant(plant, inputs, out)
        console.print(f"wrote {out}")
        return
    from sensorless.design.words import design_from
    from sensorless.envs.scenarios.words import plan_from, scenario_from
    from sensorless.evaluation.trace import trace, write_csv
    from sensorless.evaluation.trace_summary import summary_table
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policy

    machine, design = Motor.load(motor), design_from(settings)
    rule = make_policy(policy, machine)
    case = (
        scenario_from(scenario, machine)
        if scenario is not None
        else plan_from(
            speed, load, ramp, duration, machine, seed, start=start, theta_err=theta_err, spin=spin
        )
    )
    run = trace(rule, case, machine, design)
    console.print(summary_table(run, rule.name))
    if out is not None:
        write_csv(run, out)
        console.print(f"wrote {out}")
    if log is not None:
        from sensorless.replay.log import write_log

        write_log(run, log)
        console.print(f"wrote {log}")
    if plot is not None:
        from sensorless.plots.figure import save
        from sensorless.plots.waveforms import waveforms

        save(waveforms({f"{machine.name}, {rule.name}, {scenario or 'planned run'}": run}), plot)
        console.print(f"wrote {plot}")


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
    from sensorless.design.words import design_from
    from sensorless.export.export import export as write
    from sensorless.export.export import table_of
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policy
    from sensorless.policy import design_for

    machine = Motor.load(motor)
    policy = make_policy(run, machine)
    table, design = table_of(policy, run), design_for(policy, design_from(settings))
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
    from sensorless.agents.train.config import TrainConfig
    from sensorless.cli.demo_steps import ESTIMATOR, draw, fresh_folder, hand_over, judge
    from sensorless.cli.train import run_training
    from sensorless.design.drive import DriveDesign

    config = TrainConfig(minutes=minutes)
    fresh_folder(out)
    run = out / "ppo-table"
    errors.print(f"[bold]1/4[/] training a schedule for {minutes:g} min, starting from Eq. 25")
    run_training(config, DriveDesign(estimator=ESTIMATOR), run, resume=False)
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


app.command("evaluate")(evaluate_command)
app.command("report")(report_command)
app.command("train")(train_command)
app.command("distill")(distill_command)
app.command("tune")(tune_command)
app.command("pil")(pil_command)
app.add_typer(identify_app, name="identify")
app.command("reproduce")(reproduce)
app.command("replay")(replay_command)


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

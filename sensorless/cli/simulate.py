"""The command ``sensorless simulate``."""

from pathlib import Path
from typing import Annotated

import typer

from sensorless.cli.given import refuse_idle
from sensorless.cli.one_run import (
    check_outputs,
    machine_alone,
    replayed,
    say_notes,
    say_run,
    write_run,
)
from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    PolicyOption,
    SetOption,
    bench_of,
)


def simulate_command(
    context: typer.Context,
    motor: CarriedMotorOption = None,
    policy: PolicyOption = "eq25",
    speed: Annotated[
        str | None,
        typer.Option(
            metavar="PLAN",
            help="Follow this plan of speeds, TIME:SPEED,...: from each time [s] on, the reference "
            "is this speed [r/min]. Default: 0:200,1:350,2:600 at a rated speed of 1500 r/min, "
            "the same shares of any other.",
        ),
    ] = None,
    load: Annotated[
        str,
        typer.Option(
            metavar="PLAN",
            help="Follow this plan of loads, TIME:TORQUE,...: from each time [s] on, the load is "
            "this torque [N m].",
        ),
    ] = "0:0",
    ramp: Annotated[
        float | None,
        typer.Option(
            help="Let the speed reference rise and fall with this slope [r/min/s]. Default: it "
            "steps."
        ),
    ] = None,
    duration: Annotated[float, typer.Option(help="Simulate this long [s].")] = 3.0,
    scenario: Annotated[
        str | None,
        typer.Option(
            metavar="SCENARIO",
            help="Replay one scenario of a suite instead of the plans: SUITE:SEED:INDEX, or "
            "SUITE:SEED:INDEX:SIZE for the suite envelope. `sensorless evaluate` lists its worst "
            "cases this way, for example stress-1:7:12. Or FILE.json:INDEX of a file of "
            "`sensorless falsify`; with :min, all that the loss does not need is nominal. "
            "Default: the plans.",
        ),
    ] = None,
    seed: Annotated[
        int,
        typer.Option(
            metavar="N", min=0, help="Draw the noise of the current sensors from this seed."
        ),
    ] = 0,
    start: Annotated[
        bool,
        typer.Option(
            "--start",
            help="Let the drive find the rotor's angle, pole and speed before it runs. Default: "
            "it knows them.",
        ),
    ] = False,
    theta_err: Annotated[
        float,
        typer.Option(
            help="Turn the rotor this far ahead of the drive's first angle [electrical degrees]."
        ),
    ] = 0.0,
    spin: Annotated[
        float, typer.Option(help="Let the shaft spin at this speed when the run begins [r/min].")
    ] = 0.0,
    settings: SetOption = None,
    override: OverrideOption = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Draw the waveforms: FILE.png as a picture, FILE.html as a page to zoom in. "
            "Default: neither.",
        ),
    ] = None,
    show: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PANE",
            help="Draw this in a picture, too: current (i_d, i_q), voltage (u_d, u_q) or faults; "
            "repeat the option for several. A page has them all. Default: speed, torque, angle "
            "error and weight.",
        ),
    ] = None,
    as_json: JsonOption = False,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Write the run as CSV, one row per PWM period; with --plant, the machine's run. "
            "Default: no file.",
        ),
    ] = None,
    save_log: Annotated[
        Path | None,
        typer.Option(
            "--log",
            metavar="FILE.csv",
            help="Write what a real drive would record as CSV, ready for `sensorless replay`. "
            "Default: no file.",
        ),
    ] = None,
    plant: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Run only the machine of this JSON file, without a drive; needs --inputs and "
            "--out. Default: the whole drive.",
        ),
    ] = None,
    inputs: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Feed --plant with these voltages: columns u_alpha, u_beta [V] and optionally "
            "tau_L [N m], one row per PWM period. Default: no --plant.",
        ),
    ] = None,
) -> None:
    """Run one drive and look at it, or run the machine alone under given voltages.

    Prints how the drive followed its speed reference, how far its angle was off, and whether it
    kept lock, narrowly or with an alarm of its own; if not, when the drive itself noticed and what
    it did. The run goes on after that, and all numbers of the table are up to there.
    Without options it runs the speeds of Fig. 9 of the source paper under its Eq. 25: 13, 23 and
    40 % of rated speed without load, which crosses from injection to the observer.
    `--policy sliding_mode` puts that rule on the paper's observers.

    For example:

        sensorless simulate --plot fig9.png
        sensorless simulate --speed 0:150,1:650 --ramp 600 --load 0:0,0.5:6
        sensorless simulate --scenario stress-1:7:12 --policy hysteresis --out run.csv
    """
    refuse_idle(context)
    check_outputs(plot, show or (), out, save_log)
    if plant is not None or inputs is not None:
        machine_alone(plant, inputs, out)
        return
    from sensorless.envs.scenarios.words import fig9, plan_from
    from sensorless.evaluation.trace import cut_short, trace

    made = bench_of([policy], motor, settings, override)
    if scenario is not None:
        made, case = replayed(scenario, made, motor)
    else:
        machine = made.motor
        plan = fig9(machine) if speed is None else speed
        numbers = (plan, load, ramp, duration, machine, seed)
        case = plan_from(*numbers, start=start, theta_err=theta_err, spin=spin)
    machine, rule = made.motor, made.policy(policy)
    say_notes(case, made, planned=scenario is None and speed is not None)
    run = trace(rule, case, machine, made.design, go_on=True)
    short = cut_short(run, float(case.duration[0]))
    say_run(run, rule.name, machine.tau_rated, short, as_json)
    title = f"{machine.name}, {rule.name}, {scenario or 'planned run'}"
    write_run(run, title, short, out, save_log, plot, show or ())

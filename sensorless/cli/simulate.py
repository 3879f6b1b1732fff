"""The command ``sensorless simulate``."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sensorless.cli.given import refuse_idle
from sensorless.cli.options import (
    CarriedMotorOption,
    JsonOption,
    OverrideOption,
    PolicyOption,
    SetOption,
    bench_of,
    console,
    errors,
    say_json,
    say_wrote,
)
from sensorless.errors import UserError

if TYPE_CHECKING:
    from sensorless.evaluation.trace import Trace


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
    from sensorless.design.records import reference_most
    from sensorless.envs.scenarios.words import (
        fig9,
        found_elsewhere,
        own_machine,
        plan_from,
        scenario_from,
    )
    from sensorless.evaluation.trace import cut_short, trace
    from sensorless.units import RAD_S_TO_RPM

    made = bench_of([policy], motor, settings, override)
    if scenario is not None:
        given = scenario
        own, scenario = own_machine(scenario)
        if own is not None and motor is not None:
            raise UserError(f"motor: {motor!r}: {given!r} has a machine of its own; leave it out")
        made = made if own is None else made.on(own)
    machine, rule = made.motor, made.policy(policy)
    if scenario is not None:
        case = scenario_from(scenario, machine)
    else:
        plan = fig9(machine) if speed is None else speed
        case = plan_from(
            plan,
            load,
            ramp,
            duration,
            machine,
            seed,
            start=start,
            theta_err=theta_err,
            spin=spin,
        )
    if foreign := found_elsewhere(scenario or "", machine, made.design.estimator):
        errors.print(f"note: {foreign}", highlight=False, soft_wrap=True)
    last = max(t for t in case.t[0] if t < math.inf)
    if speed is not None and last >= case.duration[0]:
        text = f"note: the plan goes on to {last:g} s, but the run ends at {case.duration[0]:g} s"
        errors.print(f"{text}; --duration sets it", highlight=False, soft_wrap=True)
    most = reference_most(machine, made.design) * RAD_S_TO_RPM
    asked = float(abs(case.omega).max()) * RAD_S_TO_RPM
    if asked > most * 1.001:
        text = (
            f"note: the drive follows at most {most:.0f} r/min, not {asked:.0f} (FAULT_COMMAND): "
        )
        text += "speed_bound times rated speed, less what a rated load that goes adds"
        errors.print(text, highlight=False, soft_wrap=True)
    run = trace(rule, case, machine, made.design, go_on=True)
    short = cut_short(run, float(case.duration[0]))
    say_run(run, rule.name, short, as_json)
    title = f"{machine.name}, {rule.name}, {scenario or 'planned run'}"
    write_run(run, title, short, out, save_log, plot, show or ())


def check_outputs(
    plot: Path | None, show: Sequence[str], out: Path | None, save_log: Path | None
) -> None:
    """Check before the run that what is asked for can be drawn and written.

    Raises
    ------
    UserError
        A pane is unknown, or a file cannot be written.
    """
    from sensorless.files import check_writable
    from sensorless.plots.wave import FOLDED
    from sensorless.report.picture import check_drawable

    check_drawable(plot)
    unknown = [pane for pane in show if pane not in FOLDED]
    if unknown:
        raise UserError(f"show: {unknown[0]!r} is none of {', '.join(FOLDED)}; give one of these")
    check_writable(out, ending=".csv")
    check_writable(save_log, "log", ".csv")


def say_run(run: "Trace", name: str, short: str | None, as_json: bool) -> None:
    """Print how a run went; ``short`` says why it ended early, if it did."""
    from sensorless.evaluation.trace import outcome
    from sensorless.evaluation.trace_summary import plateaus, summary_table

    if as_json:
        facts = {"policy": name, "outcome": outcome(run), "cut_short": short}
        say_json({**facts, "plateaus": plateaus(run)})
    console.print(summary_table(run, name))
    if short is not None:
        console.print(short, highlight=False, soft_wrap=True)


def write_run(
    run: "Trace",
    title: str,
    short: str | None,
    out: Path | None,
    save_log: Path | None,
    plot: Path | None,
    show: Sequence[str],
) -> None:
    """Write the files of a run that were asked for."""
    from sensorless.evaluation.trace import write_csv
    from sensorless.plots.wave import wave
    from sensorless.replay.log import write_log
    from sensorless.report.picture import write_waves
    from sensorless.versions import typed

    if out is not None:
        write_csv(run, out)
    if save_log is not None:
        write_log(run, save_log)
    if plot is not None:
        write_waves([wave(title, run)], plot, typed(), [short] if short else [], show)
    say_wrote(out, save_log, plot)


def machine_alone(plant: Path | None, inputs: Path | None, out: Path | None) -> None:
    """Run the machine of a file under the voltages of another, without a drive.

    Raises
    ------
    UserError
        One of the three files is not given, or one is not what it should be.
    """
    from sensorless.plant.run import simulate_plant

    if plant is None or inputs is None or out is None:
        raise UserError(
            "plant, inputs: a machine alone needs --plant, --inputs and --out; give all three"
        )
    simulate_plant(plant, inputs, out)
    say_wrote(out)

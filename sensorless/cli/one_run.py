"""What one run of a drive, or of a machine alone, takes, says and writes."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sensorless.cli.options import console, errors, say_json, say_wrote
from sensorless.errors import UserError

if TYPE_CHECKING:
    from sensorless.envs.scenarios.scenario import Scenarios
    from sensorless.evaluation.trace import Trace
    from sensorless.policies.bench import Bench


def replayed(scenario: str, made: "Bench", motor: str | None) -> "tuple[Bench, Scenarios]":
    """Bench and scenario of a word, on the machine that it names, if it names one.

    Raises
    ------
    UserError
        The word cannot be read, or it names a machine and ``motor`` is given too.
    """
    from sensorless.envs.scenarios.words import found_elsewhere, own_machine, scenario_from

    own, word = own_machine(scenario)
    if own is not None and motor is not None:
        raise UserError(f"motor: {motor!r}: {scenario!r} has a machine of its own; leave it out")
    made = made if own is None else made.on(own)
    case = scenario_from(word, made.motor)
    if foreign := found_elsewhere(word, made.motor, made.design.estimator):
        errors.print(f"note: {foreign}", highlight=False, soft_wrap=True)
    return made, case


def say_notes(case: "Scenarios", made: "Bench", *, planned: bool) -> None:
    """Say on the error stream where the run does not follow the speeds that it is given."""
    from sensorless.design.records import reference_most
    from sensorless.units import RAD_S_TO_RPM

    last = max(t for t in case.t[0] if t < math.inf)
    if planned and last >= case.duration[0]:
        text = f"note: the plan goes on to {last:g} s, but the run ends at {case.duration[0]:g} s"
        errors.print(f"{text}; --duration sets it", highlight=False, soft_wrap=True)
    most = reference_most(made.motor, made.design) * RAD_S_TO_RPM
    asked = float(abs(case.omega).max()) * RAD_S_TO_RPM
    if asked > most * 1.001:
        text = (
            f"note: the drive follows at most {most:.0f} r/min, not {asked:.0f} (FAULT_COMMAND): "
            "speed_bound times rated speed, less what a rated load that goes adds"
        )
        errors.print(text, highlight=False, soft_wrap=True)


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


def say_run(run: "Trace", name: str, tau_rated: float, short: str | None, as_json: bool) -> None:
    """Print how a run went; rated torque [N m]; ``short`` says why it ended early, if it did."""
    from sensorless.evaluation.trace import outcome
    from sensorless.evaluation.trace_summary import plateaus, summary_table

    if as_json:
        facts = {"policy": name, "outcome": outcome(run), "cut_short": short}
        say_json({**facts, "plateaus": plateaus(run)})
    console.print(summary_table(run, name, tau_rated))
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

"""The command ``sensorless tune gains``."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from sensorless.cli.options import (
    JsonOption,
    MotorOption,
    SearchSeedOption,
    SetOption,
    console,
    errors,
    minutely,
    say_if_unsuited,
    say_json,
    say_verdict,
    say_wrote,
    search_progress,
)

if TYPE_CHECKING:
    from sensorless.policy import Policy

ROWS = {
    "lost_rate": ("lost, %", 100.0),
    "not_held_rate": ("not held, %", 100.0),
    "torque_dev": ("torque deviation, %", 100.0),
    "torque_ripple": ("torque ripple, %", 100.0),
    "angle error": ("angle error, deg", 1.0),
    "dip": ("dip after a load step, % s", 1.0),
    "settling": ("settling of the twin, s", 1.0),
}
"""Label and scale of each number that is shown."""


def tune_gains_command(
    motor: MotorOption = "paper",
    estimator: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Tune the gains of this estimator: coupled, smo, flux, errors or unwrapped. "
            "Default: that of --set, or else coupled.",
        ),
    ] = None,
    policy: Annotated[
        str,
        typer.Option(metavar="RULE", help="Let this rule choose the weight k_s meanwhile."),
    ] = "eq25",
    evaluations: Annotated[
        int, typer.Option(metavar="N", help="Try this many sets of gains.")
    ] = 300,
    size: Annotated[
        int, typer.Option(metavar="N", help="Run each set of gains on this many scenarios.")
    ] = 128,
    seed: SearchSeedOption = 1,
    settings: SetOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json", help="Write settings and record here. Default: only print."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Tune the gains of the drive with CMA-ES, from those that follow from the motor.

    It changes the gains of the estimator, the speed loop and the current loop, the share of the
    dead time that is compensated and the speed floor by factors of at most three. It minimises
    10 lost_rate + torque deviation + torque ripple on scenarios of stress-1 and nominal that
    training and evaluation never see. The drive stays as exact and as fast as at the start: no
    larger RMS angle error, no more scenarios whose speed is not held, no larger dip of the speed
    after a load step, no longer settling of the speed loop. What --set names stays as it is.

    It prints the --set words of the best gains found. The last line says whether they are better
    than the start on 400 scenarios that tuning has not seen. Ctrl-C keeps the best
    found so far.

    For example:

        sensorless tune gains --motor pmsyrm_5600w --out gains.json
        sensorless tune gains --estimator smo --set speed_hz=2
    """
    from sensorless.design.drive import DriveDesign
    from sensorless.design.words import asked_for
    from sensorless.errors import UserError
    from sensorless.files import check_writable
    from sensorless.machine.motor import Motor
    from sensorless.tuning.gains.choice import gains_of
    from sensorless.tuning.gains.record import record_of
    from sensorless.tuning.gains.search import search
    from sensorless.tuning.gains.verdict import judged
    from sensorless.versions import typed

    check_writable(out, ending=".json")
    machine, asked = Motor.load(motor), asked_for(settings)
    if estimator is not None:
        asked = asked_for([f"estimator={estimator}"]) | asked
    if estimator not in (None, asked.get("estimator")):
        raise UserError(f"estimator: {estimator}, but --set names another one; leave one out")
    design = DriveDesign(**asked)
    chooser = _rule(policy, machine)
    gains = gains_of(machine, design, asked)
    say_if_unsuited(machine, design)
    bar = search_progress("tuning gains")
    task = bar.add_task("", total=1.0)
    say = minutely()

    def report(done: float, best: float, start: float) -> None:
        text = f"best objective: {best:.4f}, start {start:.4f}"
        bar.update(task, completed=done, description=text)
        say(f"{100.0 * done:.0f} %, {text}")

    with bar:
        found = search(
            machine,
            design,
            chooser,
            gains,
            evaluations=evaluations,
            size=size,
            seed=seed,
            progress=report,
        )
    record = {
        "command": typed(),
        **record_of(machine, design, policy, found, size, seed),
    }
    _write(record, out)
    _show_gains(record)
    if found.interrupted:
        errors.print(f"interrupted after {found.tried} of {evaluations} sets of gains")
        raise typer.Exit(130)
    record["judged"] = judged(machine, design, chooser, found)
    _write(record, out)
    _show_judged(record["judged"].get("suites", {}))
    if out is not None:
        say_wrote(out)
    say_verdict(record["judged"]["verdict"])
    if as_json:
        say_json(record)


def _write(record: dict[str, Any], out: Path | None) -> None:
    """Write the record, if anybody wants it."""
    from sensorless.files import write_atomic

    if out is not None:
        write_atomic(out, json.dumps(record, indent=1, allow_nan=False) + "\n")


def _rule(name: str, motor: Any) -> "Policy":
    """Policy that leaves every setting to the drive."""
    from sensorless.errors import UserError
    from sensorless.policies.registry import make_policy

    made = make_policy(name, motor)
    if made.sensored or made.settings:
        raise UserError(
            f"policy: {name!r} brings a drive of its own; give a rule that does not, like eq25"
        )
    return made


def _show_gains(record: dict[str, Any]) -> None:
    """Print the gains, and the words to use them."""
    from sensorless.design.drive import DriveDesign
    from sensorless.settings import settings_of

    known, tuned = settings_of(DriveDesign), record["tuned"]
    table = Table("setting", "unit", "start", "tuned", "factor", box=None)
    for name, start in record["start"].items():
        value = tuned.get(name, start)
        unit = "" if known[name].unit == "1" else known[name].unit
        table.add_row(name, unit, f"{start:.4g}", f"{value:.4g}", f"{value / start:.2f}")
    console.print(table)
    if tuned:
        words = " ".join(f"--set {word}" for word in record["words"])
        console.print(f"settings: {words}", highlight=False, soft_wrap=True)


def _show_judged(suites: dict[str, Any]) -> None:
    """Print start and tuned gains side by side on each suite."""
    table = Table("on unseen scenarios", box=None)
    for name in suites:
        table.add_column(f"{name}: start", justify="right")
        table.add_column("tuned", justify="right")
    columns = [found[who] for found in suites.values() for who in ("start", "tuned")]
    for key, (label, scale) in ROWS.items():
        cells = (column[key] for column in columns)
        table.add_row(label, *("-" if x is None else f"{scale * x:.3g}" for x in cells))
    if suites:
        console.print(table)

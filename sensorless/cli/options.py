"""Options, consoles and progress bars that several commands share."""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from sensorless.cli.surroundings import AnyConsole

if TYPE_CHECKING:
    from sensorless.design.drive import DriveDesign
    from sensorless.machine.motor import Motor
    from sensorless.policies.bench import Bench

console = AnyConsole()
errors = AnyConsole(stderr=True)

MINUTE = 60.0
"""Time from one line of progress to the next where the output is no terminal [s]."""
EXAMPLE = "--set speed_hz=4"
POLICIES = (
    "a rule by name, with its numbers if it takes any (eq25, linear:150,450, fuzzy, ...: "
    "`sensorless evaluate --list` names them all), a file that `sensorless tune` wrote, the "
    "folder of a training run, or MODULE:NAME, your own Python class or function, which takes the "
    "motor and gives a policy"
)

MOTOR = (
    "Use this motor: the name of a shipped one (paper, ipmsm_2200w, pmsyrm_5600w, brusa_hsm1, "
    "pmsrm_15kw, formula_wheel, ebike_hub), or your own TOML file, laid out as "
    "docs/motor-file.md shows."
)
MotorOption = Annotated[str, typer.Option("--motor", metavar="MOTOR", help=MOTOR)]
CarriedMotorOption = Annotated[
    str | None,
    typer.Option(
        "--motor",
        metavar="MOTOR",
        help=f"{MOTOR} Default: the motor that the policy was made for, or else paper, that of the "
        "source paper.",
    ),
]
OverrideOption = Annotated[
    bool,
    typer.Option(
        "--override",
        help="Let --motor and --set win over the motor and the settings that a policy was made "
        "with. Default: what contradicts them is refused.",
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME=VALUE",
        help=f"Change one setting of the drive design, for example {EXAMPLE} [Hz]; repeat the "
        "option to change several; `sensorless settings` lists them all. Default: the design that "
        "follows from the motor.",
    ),
]
PolicyOption = Annotated[
    str,
    typer.Option(
        "--policy", metavar="POLICY", help=f"Let this policy choose the weight k_s: {POLICIES}."
    ),
]
SeedOption = Annotated[
    int,
    typer.Option(
        metavar="N",
        min=0,
        help="Draw the scenarios from this seed; the same seed gives the same scenarios.",
    ),
]
SearchSeedOption = Annotated[
    int,
    typer.Option(
        "--seed",
        metavar="N",
        min=0,
        help="Draw scenarios and search from this seed; it makes the run repeatable.",
    ),
]

JsonOption = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Print the numbers as JSON, for programs, and nothing else.",
        is_eager=True,  # known to --list
    ),
]
ReplaceOption = Annotated[
    bool,
    typer.Option(
        "--replace",
        help="Let --out replace a motor file that exists. Default: it is refused.",
    ),
]
QuietOption = Annotated[
    bool,
    typer.Option(
        "--quiet",
        help="Print the result and errors alone: no progress, notes, or names of files.",
    ),
]

EngineOption = Annotated[
    str,
    typer.Option(
        metavar="ENGINE",
        help="Run the scenarios in this process (local) or on a Ray cluster (ray); the result is "
        "the same to the bit.",
    ),
]
RayAddressOption = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Join the Ray cluster that runs at HOST:PORT; only with --engine ray. Default: "
        "start one on the processors of this machine.",
    ),
]


def bench_of(
    specs: Sequence[str], motor: str | None, settings: Sequence[str] | None, override: bool
) -> "Bench":
    """Bench of a command's policies; says on the error stream what a user should know.

    Raises
    ------
    UserError
        As ``bench`` and ``say_if_unsuited``.
    """
    from sensorless.policies.bench import bench

    made = bench(specs, motor, settings, override=override)
    say_if_unsuited(made.motor, made.design)
    for note in made.notes:
        errors.print(f"note: {note}", highlight=False, soft_wrap=True)
    return made


def given_again(motor: str | None, settings: Sequence[str] | None, override: bool) -> list[str]:
    """Options of a command that chose motor and drive, for another command."""
    words = [] if motor is None else ["--motor", motor]
    words += [word for pair in settings or [] for word in ("--set", pair)]
    return [*words, *(["--override"] if override else [])]


def require_machine(motor: "Motor", design: "DriveDesign") -> None:
    """Refuse a machine before any work on it.

    Raises
    ------
    UserError
        No drive can be designed for it, see ``control_record``, or its numbers contradict each
        other.
    """
    from sensorless.design.records import control_record
    from sensorless.suitability.plausible import require_plausible

    control_record(motor, design)
    require_plausible(motor)


def say_if_unsuited(motor: "Motor", design: "DriveDesign") -> None:
    """Print the verdict of the check without its simulation, unless it is yes.

    Raises
    ------
    UserError
        As ``require_machine``.
    """
    from sensorless.design.derived import derive
    from sensorless.suitability.examine import examine

    require_machine(motor, design)
    verdict = examine(motor, derive(motor, design).hfi_pll_hz).verdict
    if verdict.word != "yes":
        text = Text.assemble((motor.name, "bold"), f": {verdict}")
        errors.print(text, highlight=False, soft_wrap=True)


def say_json(data: object) -> None:
    """Print data for programs; what is no number becomes null."""
    from sensorless.plain_json import plain

    typer.echo(json.dumps(plain(data), indent=1))


def say_wrote(*paths: Path | None) -> None:
    """Name the files that a command wrote, on the error stream: programs read the other one."""
    for path in filter(None, paths):
        errors.print(f"wrote {path}", highlight=False, soft_wrap=True)


def describe(scores: Mapping[str, float]) -> str:
    """Say the scores of a ``Cost`` in words."""
    return (
        f"lost {100 * scores['lost_rate']:.1f} %, torque deviation "
        f"{100 * scores['torque_dev']:.2f} %, torque ripple {100 * scores['torque_ripple']:.2f} %"
    )


def say_verdict(sentence: str) -> None:
    """Print the sentence that a command ends with."""
    console.print(f"verdict: {sentence}", highlight=False, soft_wrap=True)


def minutely() -> Callable[[str], None]:
    """Printer of progress where no terminal shows a bar: a line a minute at most."""
    last = time.monotonic()

    def say(text: str) -> None:
        nonlocal last
        if not errors.is_terminal and time.monotonic() - last >= MINUTE:
            last = time.monotonic()
            errors.print(text, highlight=False, soft_wrap=True)

    return say


def search_progress(what: str) -> Progress:
    """Bar of a search with the time that is left; its task's description says how far it came."""
    return Progress(
        TextColumn(what, markup=False),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.description}"),
        console=errors,
        disable=not errors.is_terminal,
    )


@contextmanager
def policy_progress() -> Iterator[Callable[[str, float], None]]:
    """Progress of several policies: bars on a terminal, otherwise a line when one is done."""
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        TimeElapsedColumn(),
        console=errors,
        disable=not errors.is_terminal,
    )
    tasks: dict[str, TaskID] = {}
    say = minutely()

    def report(name: str, done: float) -> None:
        if name not in tasks:
            tasks[name] = bar.add_task(name, total=1.0)
        bar.update(tasks[name], completed=done)
        say(f"{name}: {100.0 * done:.0f} %")
        if done >= 1.0 and not errors.is_terminal:
            errors.print(f"evaluated {name}", highlight=False)

    with bar:
        yield report

"""The steps of ``sensorless demo``: judge, draw, export."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sensorless.agents.train.alone import alone
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import fig9, plan_from, scenario_from
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import PolicyProgress, evaluate
from sensorless.evaluation.results import Results
from sensorless.evaluation.trace import trace
from sensorless.export.export import export, table_of
from sensorless.export.judge import judge_export
from sensorless.files import ensure_writable, reason, remove
from sensorless.machine.motor import Motor
from sensorless.plots.figure import save
from sensorless.plots.schedule import schedule_maps
from sensorless.plots.wave import wave
from sensorless.plots.waveforms import waveforms
from sensorless.policies.registry import make_policies, make_policy
from sensorless.policy import TablePolicy, design_for

MARK = ".sensorless-demo"
SUITE = "stress-1"
"""Suite that the demo judges on."""
RULES = ("sliding_mode", "eq25")
"""Eq. 25 on the paper's observers, and on the drive that the schedule is trained on."""


@contextmanager
def fresh_folder(folder: Path, motor: str) -> Iterator[None]:
    """Make an empty folder, or empty one that an earlier demo wrote, for this demo alone.

    Raises
    ------
    UserError
        The folder holds something else, or the file of the motor, or another demo writes to it.
    """
    if Path(motor).is_file() and folder.resolve() in Path(motor).resolve().parents:
        raise UserError(
            f"out: {str(folder)!r} holds the file of --motor, and is emptied; give a new folder"
        )
    try:
        _refuse_other(folder)
    except OSError as error:
        raise UserError(f"out: {str(folder)!r}: {reason(error)}; give another folder") from None
    ensure_writable(folder)
    with alone(folder, "out", "demo"):
        (folder / MARK).touch()
        for path in list(folder.iterdir()):
            if path.name != MARK:  # first and last, so that the next demo knows the folder
                remove(path)
        yield


def _refuse_other(folder: Path) -> None:
    if folder.exists() and (
        not folder.is_dir() or (any(folder.iterdir()) and not (folder / MARK).is_file())
    ):
        what = "holds other files" if folder.is_dir() else "is a file"
        raise UserError(
            f"out: {str(folder)!r} {what}; give a new folder, or that of an earlier demo"
        )


def judge(
    folder: Path, run: str, motor: Motor, size: int, seed: int, report: PolicyProgress
) -> Results:
    """Judge the rules, the trained table and the sensored drive on ``SUITE``."""
    policies = make_policies([*RULES, run, "sensored"], motor)
    out = folder / "results.json"
    return evaluate(motor, DriveDesign(), SUITE, seed, size, policies, out=out, progress=report)


def draw(folder: Path, run: str, motor: Motor, results: Results) -> list[Path]:
    """Figures: Fig. 9, the schedules, and the hand-over where the paper's drive fared worst.

    Another motor runs the speeds of Fig. 9 as shares of its rated speed.
    """
    design = DriveDesign()
    paper, learned = make_policy("sliding_mode", motor), make_policy(run, motor)
    paths = [folder / name for name in ("fig9.png", "schedules.png", "hand-over.png")]
    plan = plan_from(fig9(motor), "0:0", None, 3.0, motor, 0)
    run_9 = trace(paper, plan, motor, design)
    save(
        waveforms([wave("Fig. 9 under Eq. 25 on the paper's observers, no load", run_9)]), paths[0]
    )
    assert isinstance(paper, TablePolicy) and isinstance(learned, TablePolicy)
    save(schedule_maps(learned.name, learned.table, paper.table, motor), paths[1])
    word = results.policies[paper.name]["worst"][0]["scenario"]
    case = scenario_from(word, motor)
    waves = [
        wave(f"{word} under {policy.name}", trace(policy, case, motor, design))
        for policy in (paper, learned)
    ]
    save(waveforms(waves), paths[2])
    return paths


def hand_over(folder: Path, run: str, motor: Motor) -> tuple[Path, str]:
    """Export the trained table with its verdict; returns the folder and what its self test said."""
    policy = make_policy(run, motor)
    table, design = table_of(policy, run), design_for(policy, DriveDesign())
    judged = judge_export(policy, motor, design)
    done = export(table, motor, design, folder / "firmware", policy=policy.name, judged=judged)
    return done.folder, done.self_test.message

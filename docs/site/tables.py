"""Tables of the site, from the motor files and from what ``make reference`` recorded."""

from pathlib import Path

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.best import best
from sensorless.suitability.examine import examine

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results" / "reference" / "results.md"
SUITES = ("stress-1", "stress", "handoff")
"""The first one orders the leaderboard."""
LOST, DEVIATION, RIPPLE = "lost [%]", "torque deviation [%]", "torque ripple [%]"
SHOWN = (LOST, DEVIATION, RIPPLE, "angle error [°]", "injection on [%]")

Row = dict[str, str]
"""One policy's cells by column."""


def _page(name: str, **made: str) -> str:
    """Text beside this file with what is made put in its place."""
    text = Path(__file__).with_name(name).read_text(encoding="utf-8")
    return text.format(**made)


def recorded(suite: str) -> dict[str, Row]:
    """Rows of the reference's page of results on a suite, by policy."""
    text = RESULTS.read_text(encoding="utf-8")
    (part,) = (part for part in text.split("\n## ") if part.startswith(f"`{suite}`"))
    lines = [line.strip("| ").split(" | ") for line in part.splitlines() if line.startswith("| ")]
    return {line[0]: dict(zip(lines[0], line, strict=True)) for line in lines[1:]}


def objective(row: Row) -> float:
    """Objective of training and tuning in percent: 10 lost + torque deviation + torque ripple."""
    lost, deviation, ripple = (float(row[column].split()[0]) for column in SHOWN[:3])
    return 10.0 * lost + deviation + ripple


def ranked() -> list[str]:
    """Policies that a drive could run, the best first; the single training seeds are left out."""
    rows = recorded(SUITES[0])
    able = [name for name in rows if "seed-" not in name and name not in ("sensored", "oracle")]
    return sorted(able, key=lambda name: objective(rows[name]))


def leaderboard() -> str:
    """Page of the site: the policies of the reference in the order of the objective."""
    rows = {suite: recorded(suite) for suite in SUITES}
    heading = ["", "policy", "estimator"]
    heading += [f"objective, `{suite}` [%]" for suite in SUITES] + list(SHOWN)
    lines = [f"| {' | '.join(heading)} |", "|" + "---|" * len(heading)]
    for place, name in enumerate(ranked(), 1):
        row = rows[SUITES[0]][name]
        cells = [str(place), f"`{name}`", row["estimator"]]
        cells += [f"{objective(rows[suite][name]):.2f}" for suite in SUITES]
        cells += [row[column].replace(" ± ", "&nbsp;±&nbsp;") for column in SHOWN]
        lines.append(f"| {' | '.join(cells)} |")
    table = "\n".join(lines)
    return _page("leaderboard.md", table=table)


def motors() -> str:
    """Page of the site: the machines that come with the package."""
    heading = ("motor", "what it is", "N m", "r/min", "V", "poles", "L_q/L_d", "suits")
    lines = [f"| {' | '.join(heading)} |", "|" + "---|" * len(heading)]
    schedules = []
    for path in sorted(MOTORS.glob("*.toml")):
        motor = Motor.load(path)
        verdict = examine(motor, derive(motor, DriveDesign()).hfi_pll_hz).verdict.word
        numbers = (motor.tau_rated, motor.n_rated_rpm, motor.u_dc, 2 * motor.n_p)
        cells = (
            f"`{motor.name}`",
            motor.description,
            *(f"{number:g}" for number in numbers),
            f"{motor.L_q / motor.L_d:.2f}",
            verdict,
        )
        lines.append(f"| {' | '.join(cells)} |")
        found = best(motor)
        if found is not None:
            unfit = f" Unfit for export: {found.objection}." if found.objection else ""
            since = "" if found.fresh else " Motor or drive have changed since."
            schedules.append(f"- `{motor.name}`: `{found.policy}`. {found.verdict}.{unfit}{since}")
    table, best_of = "\n".join(lines), "\n".join(schedules)
    return _page("motors.md", table=table, best_of=best_of)

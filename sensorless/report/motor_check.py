"""Check of a machine: examined on paper, then simulated briefly; as a table or as a page."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.text import Text

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import RatedPoint
from sensorless.observers.start_design import knows_poles
from sensorless.plain_table import PlainTable
from sensorless.policies.registry import make_policy
from sensorless.report.machine_curves import reach, signal
from sensorless.report.page import UPLOT, render
from sensorless.suitability.examine import Examination, examine
from sensorless.suitability.finding import LIMIT, NO, Finding
from sensorless.suitability.seen import Seen

Row = tuple[str, str, str]
"""Quantity, what was found, and what is suggested, in words."""
SUITES, SEED, SIZE = ("stress", "unload", "braking"), 1, 100
"""Scenarios of a quick run: all that is uncertain, and loads at low speed that go or drive."""
LOST = (0.05, 0.2)
"""Lost share of a quick run above which the drive is limited, or unable."""
LOOSE = 0.05
"""Share of a quick run, lost or not held, above which the drive is limited."""
INFEASIBLE = 0.05
"""Share of a quick run that the sensored twin fails too, above which the drive is limited."""


@dataclass(frozen=True)
class QuickRun:
    """Eq. 25, the source paper's rule, on scenarios of a suite."""

    suite: str
    size: int
    lost: float
    """share of the feasible scenarios"""
    not_held: float
    """share of the feasible scenarios in which lock is kept, but not the speed"""
    infeasible: float
    """share in which the sensored twin itself trips or runs away"""
    torque_dev: float
    """mean torque deviation from the twin where lock is kept, over rated torque"""
    tripped: float = 0.0
    """share of the lost ones in which the current limit ended it"""


@dataclass(frozen=True)
class Check:
    """Result of a check."""

    examination: Examination
    runs: tuple[QuickRun, ...]
    """one for each of ``SUITES``; none where the examination says no, or for size 0"""


def check(motor: Motor, design: DriveDesign, size: int = SIZE) -> Check:
    """Examine a machine, and simulate it unless the verdict is no; ``size`` 0: examine only."""
    try:
        e = examine(motor, derive(motor, design).hfi_pll_hz)
    except UserError:  # of no drive at all: say why, whatever its loops are
        e = examine(motor, 1.0)
        if e.verdict.word != "no":
            raise
    if e.verdict.word == "no" or size == 0:
        return Check(e, ())
    runs = tuple(_quick_run(motor, design, suite, size) for suite in SUITES)
    speed_hz = derive(motor, design).speed_hz
    found = (finding for run in runs for finding in judged(run, speed_hz))
    return Check(replace(e, findings=(*e.findings, *found)), runs)


def _quick_run(motor: Motor, design: DriveDesign, suite: str, size: int) -> QuickRun:
    policies = {"eq25": make_policy("eq25", motor)}
    result = evaluate(motor, design, suite, SEED, size, policies).policies["eq25"]
    causes = result["lost_by_cause"]
    return QuickRun(
        suite, size, result["lost_rate"], result["not_held_rate"], result["infeasible_rate"],
        result["torque_dev_rms"],
        causes["current"] / max(1, sum(causes.values()) - causes["twin"]),
    )  # fmt: skip


def judged(run: QuickRun, speed_hz: float) -> list[Finding]:
    """What a quick run adds to the verdict; ``speed_hz`` [Hz] of the drive that ran."""
    found = []
    if run.infeasible == 1.0:
        return [Finding(NO, "run", f"even with an encoder, the drive fails all of {run.suite}")]
    if run.infeasible > INFEASIBLE:
        text = f"even with an encoder, the drive fails {run.infeasible:.0%} of {run.suite}"
        found.append(Finding(LIMIT, "run", text))
    if not run.lost <= LOST[0]:
        text = (
            f"the drive under Eq. 25 loses {run.lost:.0%} of the feasible scenarios of {run.suite}"
        )
        if run.tripped > 0.5:
            text += ", mostly by i_trip: a shorter T_s lets the current loop follow"
        found.append(Finding(NO if not run.lost <= LOST[1] else LIMIT, "run", text))
    if run.not_held > 0.0 and run.lost + run.not_held > LOOSE:
        text = "the drive under Eq. 25 keeps its angle, but swings or stays off its speed in "
        text += f"{run.not_held:.0%} of the feasible scenarios of {run.suite}"
        text += ": smaller offsets of the current sensors, less dead time or a slower speed loop, "
        text += f"--set speed_hz={0.4 * speed_hz:.2g} instead of {speed_hz:.3g}, may hold it"
        found.append(Finding(LIMIT, "run", text))
    return found


def rows(c: Check) -> list[Row]:
    """Everything that a check found."""
    e = c.examination
    out = [] if e.point is None else _reached(e.motor, e.point)
    if e.seen is not None and e.suggested is not None:
        out += _seen(e.motor, e.seen, e.suggested)
    return [*out, *map(_quick, c.runs)]


def _reached(m: Motor, p: RatedPoint) -> list[Row]:
    """Rows on what the machine can do within current and voltage."""
    top = f"{p.top_speed:.0f} r/min" if math.isfinite(p.top_speed) else "any"
    least = f"{p.current:.3g} A" if math.isfinite(p.current) else "more than i_max"
    return [
        (
            "rated torque",
            f"{m.tau_rated:g} N m needs {least}; rated current is {m.i_rated:g} A",
            "",
        ),
        (
            "rated speed",
            f"{m.n_rated_rpm:g} r/min: {p.torque_at_speed:.3g} N m within {m.u_dc:g} V; "
            f"field weakening from {p.base_speed:.0f} r/min",
            "",
        ),
        ("speed without load", f"{top} without field weakening", ""),
    ]


def _seen(m: Motor, seen: Seen, hint: Mapping[str, float]) -> list[Row]:
    """Rows on what injection and the converter see of the machine."""
    s, k = seen.signal, seen.rated
    cross = np.abs(seen.cross_deg)
    return [
        (
            "L_q / L_d, incremental",
            f"{s.ratio[0]:.2f} at rest, {s.ratio[k]:.2f} at rated current, "
            f"{s.ratio[-1]:.2f} at i_max",
            "",
        ),
        ("cross-coupling", f"{cross[k]:.1f}° at rated current, at most {cross.max():.1f}°", ""),
        (
            "injection",
            f"{m.u_inj:g} V, {s.amplitude:.3g} A; one degree of error shows as "
            f"{1e3 * np.deg2rad(s.slope[: k + 1].min()):.3g} mA",
            f"u_inj = {hint['u_inj']:g} V",
        ),
        (
            "angle noise to expect",
            f"{s.noise_deg[: k + 1].max():.2f}° RMS; one step of the converter "
            f"{s.step_deg[: k + 1].max():.1f}°",
            "",
        ),
        ("start", "finds the rotor from any angle" if knows_poles(m) else
         "from a known angle only: the iron of the file does not saturate along d", ""),
        ("trip", f"{m.i_trip:g} A", f"i_trip of at least {hint['i_trip']:g} A"),
        ("converter", f"{m.adc_range:g} A, {m.adc_bits} bits",
         f"adc_range of at least {hint['adc_range']:g} A, for control"),
        ("PWM period", f"{1e6 * m.T_s:g} µs, "
         f"{2.0 * math.pi / (m.omega_rated * m.T_s):.0f} per electrical turn at rated speed",
         f"T_s of at most {1e6 * hint['T_s']:g} µs"),
    ]  # fmt: skip


def _quick(run: QuickRun) -> Row:
    """Row on a quick run."""
    found = f"not feasible {run.infeasible:.0%} (fails with an encoder too)"
    if run.infeasible < 1.0:
        if math.isfinite(run.torque_dev):  # it is of what kept lock
            found = f"torque deviation {100 * run.torque_dev:.2f} %, {found}"
        found = f"lost {run.lost:.0%}, speed not held {run.not_held:.0%}, {found}"
    return f"quick run, {run.size} of suite {run.suite}", found, ""


def facts(c: Check) -> dict[str, Any]:
    """The result in JSON types."""
    return {
        "motor": c.examination.motor.name,
        "suitable": c.examination.verdict.word,
        "verdict": str(c.examination.verdict),
        "quantities": {what: {"found": found, "suggested": hint} for what, found, hint in rows(c)},
        "findings": [asdict(finding) for finding in c.examination.findings],
        "runs": [asdict(run) for run in c.runs],
    }


def screen(c: Check) -> PlainTable:
    """The result as a table for the terminal."""
    m = c.examination.motor
    table = PlainTable(
        title=f"{m.name}: {m.description}", title_justify="left", box=None, padding=(0, 1)
    )
    for heading in ("quantity", "found"):
        table.add_column(heading, no_wrap=heading == "quantity")
    for what, found, hint in rows(c):
        table.add_row(what, found + (f"; suggested: {hint}" if hint else ""))
    for finding in c.examination.findings:
        table.add_row(Text(f"{finding.weight}: {finding.field}", "bold"), finding.text)
    return table


def write_page(c: Check, path: Path, command: str) -> None:
    """Write the result as one HTML page without other files."""
    e = c.examination
    panels = [] if e.point is None else [reach(e.motor)]
    first = len(panels)  # of what injection sees
    panels += [] if e.seen is None else signal(e.motor, e.seen)
    page = render(
        "motor.html.j2",
        {"maps": {}, "cases": {}, "curves": panels},
        motor=e.motor, verdict=str(e.verdict), word=e.verdict.word, rows=rows(c),
        findings=e.findings, reach=range(first), seen=range(first, len(panels)),
        labels=[panel["label"] for panel in panels], command=command, uplot=UPLOT,
    )  # fmt: skip
    write_atomic(path, page)

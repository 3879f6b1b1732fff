"""The check of a machine as a table or as a page."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Group
from rich.text import Text

from sensorless.design.derived import back_after
from sensorless.design.drive import DriveDesign
from sensorless.design.words import words_of
from sensorless.evaluation.machine_check import LOST, SIZE, Check, QuickRun
from sensorless.evaluation.machine_check import check as run_check
from sensorless.evaluation.rates import rate_interval
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.machine.rated_point import RatedPoint
from sensorless.observers.start_design import alike, knows_poles
from sensorless.plain_table import PlainTable
from sensorless.policies.registry import make_policy
from sensorless.report.machine_curves import reach, signal
from sensorless.report.page import UPLOT, render
from sensorless.suitability.finding import NOTE
from sensorless.suitability.seen import Seen, near, reaches

Row = tuple[str, str, str]
"""Quantity, what was found, and what is suggested, in words."""


def check(motor: Motor, design: DriveDesign, size: int = SIZE) -> Check:
    """Examine a machine, and simulate it under Eq. 25; as ``machine_check.check``."""
    return run_check(motor, design, make_policy("eq25", motor), "Eq. 25", size)


def rows(c: Check) -> list[Row]:
    """Everything that a check found."""
    e = c.examination
    out = [] if e.point is None else _reached(e.motor, e.point)
    if e.seen is not None and e.suggested is not None:
        out += _seen(e.motor, e.seen, e.suggested)
    if math.isfinite(c.dip):
        dips = f"a rated load at once dips the speed by some {c.dip:.0%} of rated, for "
        dips += f"{back_after(e.motor, c.dip, SETTLED):.2g} s until it is within {SETTLED:.0%}"
        out.append(("load step", dips, ""))
    return out


def _reached(m: Motor, p: RatedPoint) -> list[Row]:
    """Rows on what the machine can do within current and voltage."""
    top = f"{p.top_speed:.0f} r/min" if math.isfinite(p.top_speed) else "any"
    least = f"{p.current:.3g} A" if math.isfinite(p.current) else "more than i_max"
    return [
        (
            "rated torque",
            f"{m.tau_rated:g} N m needs {least}; rated current is {m.i_rated:g} A peak",
            "",
        ),
        (
            "magnet",
            f"{m.psi_f:.4g} Vs peak, {m.n_p} pole pair{'s' if m.n_p > 1 else ''}: "
            f"{m.omega_rated / (2.0 * math.pi):.4g} Hz at rated speed",
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
        (
            "error of up to 20°",
            f"injection sees {seen.pulled[: k + 1].min():.2f} of it or more up to rated current, "
            f"{seen.pulled.min():.2f} up to i_max",
            "",
        ),
        ("cross-coupling", f"{cross[k]:.1f}° at rated current, at most {cross.max():.1f}°", ""),
        (
            "injection",
            f"{m.u_inj:g} V, {s.amplitude:.3g} A; one degree of error shows as "
            f"{1e3 * np.deg2rad(s.slope[: k + 1].min()):.3g} mA",
            "" if near(hint["u_inj"], m.u_inj) else f"u_inj = {hint['u_inj']:g} V",
        ),
        (
            "angle noise under load",
            f"{s.noise_deg[: k + 1].max():.2f}° RMS of the sensors; one step of the converter "
            f"{s.step_deg[: k + 1].max():.1f}°; dead time adds to it near zero current",
            "",
        ),
        ("start", "finds the rotor from any angle" if knows_poles(m) else
         f"from a known angle only: {alike(m)}", ""),
        ("trip", f"{m.i_trip:g} A peak",
         "" if reaches(m.i_trip, hint["i_trip"]) else f"i_trip of at least {hint['i_trip']:g} A"),
        ("converter", f"±{m.adc_range:g} A, {m.adc_bits} bits",
         "" if reaches(m.adc_range, hint["adc_range"]) else
         f"adc_range of at least {hint['adc_range']:g} A, for control"),
        ("PWM period", f"{1e6 * m.T_s:g} µs, "
         f"{2.0 * math.pi / (m.omega_rated * m.T_s):.0f} per electrical turn at rated speed",
         "" if m.T_s <= hint["T_s"] else f"T_s of at most {1e6 * hint['T_s']:g} µs"),
    ]  # fmt: skip


SETTLED = 0.02
"""Deviation of the speed, over rated speed, at which a load step is over."""
RUNS = ("scenarios of", "lost", "slipped", "not held", "alarms", "deviation", "infeasible")
"""Columns of the quick runs."""
RUNS_SAY = (
    "shares of the feasible scenarios, those that a drive with an encoder can do: lost, slipped "
    "and back, speed not held, alarms of the drive itself where it holds; deviation of the torque "
    "from that drive's"
)


def runs_say(c: Check) -> str:
    """What the columns are, and how far a share may be from that of many scenarios."""
    size = c.runs[0].size if c.runs else SIZE
    hits = np.arange(size) < round(LOST[0] * size)
    least, most = rate_interval(hits)
    return (
        f"{RUNS_SAY}. Of {size}, {hits.mean():.0%} may be {least:.0%} to {most:.0%} of many (95%): "
        "a larger --size tells more"
    )


def run_rows(c: Check) -> list[tuple[str, ...]]:
    """Cells of ``RUNS`` of each quick run."""
    return [_quick(run) for run in c.runs]


def _quick(run: QuickRun) -> tuple[str, ...]:
    name, infeasible = f"{run.size} {run.suite}", f"{run.infeasible:.0%}"
    if run.infeasible == 1.0:
        return (name, *("–" for _ in RUNS[2:]), infeasible)
    shares = (f"{x:.0%}" for x in (run.lost, run.slipped, run.not_held, run.alarms))
    off = f"{100.0 * run.torque_dev:.2f} %" if math.isfinite(run.torque_dev) else "–"
    return (name, *shares, off, infeasible)


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


def screen(c: Check) -> Group:
    """The result as tables for the terminal."""
    m = c.examination.motor
    table = PlainTable(
        title=f"{m.name}: {m.description}", title_justify="left", box=None, padding=(0, 1)
    )
    for heading in ("quantity", "found"):
        table.add_column(heading, no_wrap=heading == "quantity")
    for what, found, hint in rows(c):
        table.add_row(what, found + (f"; suggested: {hint}" if hint else ""))
    notes = PlainTable(box=None, padding=(0, 1), show_header=False)
    for finding in c.examination.findings:
        if finding.weight != NOTE:  # the others are the reasons below
            continue
        notes.add_row(Text(f"{finding.weight}: {finding.field}", "bold"), finding.text)
    return Group(table, *_runs(c), notes)


def _runs(c: Check) -> Iterator[PlainTable | Text]:
    """Table of the quick runs, if there were any, and what its columns are."""
    if not c.runs:
        return
    runs = PlainTable(box=None, padding=(0, 1))
    for heading in RUNS:
        runs.add_column(heading, no_wrap=True, justify="left" if heading == RUNS[0] else "right")
    for cells in run_rows(c):
        runs.add_row(*cells)
    yield runs
    yield Text(f" {runs_say(c)}", "dim")


def write_page(c: Check, path: Path, design: DriveDesign, command: str) -> None:
    """Write the result as one HTML page without other files, with the command that was typed."""
    e = c.examination
    panels = [] if e.point is None else [reach(e.motor)]
    first = len(panels)  # of what injection sees
    panels += [] if e.seen is None else signal(e.motor, e.seen)
    page = render(
        "motor.html.j2",
        {"maps": {}, "cases": {}, "curves": panels},
        motor=e.motor, verdict=e.verdict, word=e.verdict.word, rows=rows(c),
        hints=any(hint for _, _, hint in rows(c)),
        columns=RUNS, runs=run_rows(c), runs_say=runs_say(c),
        drive=", ".join(words_of(design)),
        findings=e.findings, reach=range(first), seen=range(first, len(panels)),
        labels=[panel["label"] for panel in panels], command=command, uplot=UPLOT,
    )  # fmt: skip
    write_atomic(path, page)

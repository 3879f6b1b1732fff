"""What stays unseen of faulty sensors, a wrong link voltage and broken interrupts.

    python studies/fault_campaign.py [--motor paper] [--seeds 5] [--estimator coupled smo flux]

Every fault of ``FAULTS`` with every size, for every duration of ``DURATIONS``, on every estimator,
each in several scenarios of ``stress-1``; Eq. 25 is the schedule. Scenarios in which the drive is
lost without a fault are left out. The bridge opens when the drive says over-current, and when the
hardware trips at ``i_trip``, which needs no software and which the firmware passes on
(``drive_trip``): ``lost`` counts wrong angles, ``tripped`` trips of the hardware. A loss is unseen
if no fault bit comes within ``LATEST`` of it, untold if none comes at all; a trip is unseen if the
drive had none before.
``unseen peak`` is the largest current before the first bit. Writes
``results/studies/fault_campaign.json``.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.baselines.linear import eq25_band
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.core.api import Array, enumeration, ffi, lib, pointer, struct_dtype
from sensorless.decision import decision_periods
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.errors import in_one_line
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.versions import versions

KINDS = enumeration("FAULTY_")
END = struct_dtype("faulty_end_t")
FAULTY = struct_dtype("faulty_t")
LATEST = 0.05
"""Time from the verdict of the judge to the fault bit [s]."""
FROM = 0.7
"""Begin of the fault [s]; by then the drive runs under load."""
DURATIONS = (0.002, 0.02, 0.2, 10.0)
"""[s]; the last is longer than any scenario."""
CURRENTS = ("offset", "stuck", "noise", "saturated")
"""Kinds whose size is a current: in ``FAULTS`` over ``adc_range``."""
FAULTS: dict[str, tuple[float, ...]] = {
    "offset": (-0.5, 0.1, 0.3, 1.5),
    "gain": (0.0, 0.5, 1.5),
    "gains": (0.4, 0.7, 1.4),
    "stuck": (-0.95, 0.1, 0.5, 2.0),
    "frozen": (0.0,),
    "open": (0.0,),
    "noise": (0.02, 0.1, 0.3),
    "saturated": (0.1, 0.3, 0.5),
    "swapped": (0.0,),
    "reversed": (0.0,),
    "link": (0.0, 0.4, 0.6, 1.3, 3.0),
    "missed": (0.1, 0.5, 0.9),
    "doubled": (0.1, 0.5, 1.0),
    "late": (1.0, 2.0, 3.0),
}


@dataclass(frozen=True)
class Case:
    """One fault of one size [its unit] and duration [s]; ``none`` for a healthy drive."""

    kind: str
    size: float
    duration: float


def cases() -> Iterator[Case]:
    """Every fault, size and duration."""
    for kind, sizes in FAULTS.items():
        for size in sizes:
            for duration in DURATIONS:
                yield Case(kind, size, duration)


def run(motor: Motor, design: DriveDesign, plan: list[Case], seeds: range) -> Array:
    """Ends ``faulty_end_t`` of all cases (n, seeds)."""
    s = stress_1_scenarios(motor, np.array(list(seeds), dtype=np.uint64))
    start = SimFactory(motor, design).build(s, twin=False)
    sims = np.tile(start, len(plan))
    faults = np.zeros(len(sims), dtype=FAULTY)
    for j, case in enumerate(plan):
        rows = slice(j * len(seeds), (j + 1) * len(seeds))
        scale = motor.adc_range if case.kind in CURRENTS else 1.0
        faults["kind"][rows], faults["size"][rows] = KINDS[case.kind], scale * case.size
        faults["from"][rows] = round(FROM / motor.T_s)
        faults["to"][rows] = round((FROM + case.duration) / motor.T_s)
    schedule = ffi.new("ks_schedule_params_t *")
    schedule.rule.x_min, schedule.rule.x_max = eq25_band(motor)
    schedule.periods = decision_periods(motor)
    end = np.zeros(len(sims), dtype=END)
    lib.faulty_run(
        pointer(sims, "sim_t[]"),
        len(sims),
        pointer(faults, "faulty_t[]"),
        schedule,
        pointer(end, "faulty_end_t[]"),
    )
    return end.reshape(len(plan), len(seeds))


def harmed(end: Array, cause: int) -> Array:
    """Whether the drive ended with a ``LOST_`` bit."""
    return np.asarray(end["lost"] & cause != 0)


def unseen(end: Array, T_s: float) -> Array:
    """Whether no fault bit came in time, had the drive been lost."""
    in_time = (end["k_flag"] >= 0) & (end["k_flag"] <= end["k_lost"] + round(LATEST / T_s))
    return np.asarray(~in_time)


def summary(end: Array, plan: list[Case], T_s: float) -> dict[str, dict[str, Any]]:
    """Counts and largest currents by kind of fault."""
    kinds = np.array([case.kind for case in plan])
    out = {}
    for kind in dict.fromkeys(kinds.tolist()):
        rows = end[kinds == kind]
        out[kind] = {
            "cases": int(rows.size),
            "flagged": int((rows["k_flag"] >= 0).sum()),
            "lost": int(harmed(rows, lib.LOST_ANGLE).sum()),
            "lost_unseen": int((harmed(rows, lib.LOST_ANGLE) & unseen(rows, T_s)).sum()),
            "lost_untold": int((harmed(rows, lib.LOST_ANGLE) & (rows["k_flag"] < 0)).sum()),
            "tripped": int(harmed(rows, lib.LOST_CURRENT).sum()),
            "tripped_unseen": int(rows["by_trip"].sum()),
            "peak_A": float(rows["i_peak"].max()),
            "unseen_peak_A": float(rows["i_unseen"].max()),
        }
    return out


def show(found: dict[str, dict[str, Any]], title: str) -> Table:
    """Table for the terminal."""
    table = Table("fault", title=title)
    columns = {
        "cases": "cases",
        "flagged": "flagged",
        "lost": "lost",
        "lost_unseen": "unseen",
        "lost_untold": "untold",
        "tripped": "tripped",
        "tripped_unseen": "unseen",
        "peak_A": "peak, A",
        "unseen_peak_A": "unseen peak, A",
    }
    for heading in columns.values():
        table.add_column(heading, justify="right")
    every = {
        key: max(row[key] for row in found.values())
        if "_A" in key
        else sum(row[key] for row in found.values())
        for key in columns
    }
    for kind, row in {**found, "all": every}.items():
        table.add_row(
            kind, *(f"{row[key]:.1f}" if "_A" in key else str(row[key]) for key in columns)
        )
    return table


def main() -> None:
    """Run, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--motor", default="paper", help="name or motor file")
    parser.add_argument("--estimator", nargs="+", default=list(ESTIMATORS))
    parser.add_argument("--seed", type=a_seed, default=101)
    parser.add_argument("--seeds", type=a_count, default=5, help="scenarios for each fault")
    parser.add_argument("--out", type=Path, default=Path("results/studies/fault_campaign.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    motor, plan, console = Motor.load(options.motor), list(cases()), Console()
    seeds = range(options.seed, options.seed + options.seeds)
    record: dict[str, Any] = {"motor": motor.name, "seeds": list(seeds), "versions": versions()}
    for name in options.estimator:
        design = DriveDesign(estimator=name)
        held = run(motor, design, [Case("none", 0.0, 0.0)], seeds)[0]["lost"] == 0
        end = run(motor, design, plan, seeds)[:, held]
        found = summary(end, plan, motor.T_s)
        record[name] = {"scenarios": int(held.sum()), "faults": found}
        console.print(show(found, f"{motor.name}, {name}"))
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)

"""Run the drive, with the gains that follow from each machine file, on many machines.

    python studies/any_machine.py [--set NAME=VALUE] [--motor NAME|FILE ...] [--family 24]
        [--suite NAME ...]

Eq. 25 on every shipped machine, those of --motor, and the first random ones of a family, on each
--suite. Infeasible scenarios, those in which the sensored twin fails, count apart. With --out the
result is written to a file.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.design.words import design_from
from sensorless.envs.scenarios.machine_family import NAME, family
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SUITES as KNOWN
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.aggregate import summary
from sensorless.evaluation.evaluate import score
from sensorless.files import check_writable, write_record
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

SUITES = ("nominal", "stress-1")
METRICS = ("torque_dev_rms", "torque_ripple_rms", "angle_err_rms_deg")


def judged(motor: Motor, design: DriveDesign, suite: str, seed: int, size: int) -> dict[str, Any]:
    """Lost and infeasible rates and means of one machine on one suite."""
    s = score(
        make_policy("eq25", motor), SuiteRows(suite, motor, seed, size), SimFactory(motor, design)
    )
    found = summary(s.lost, {name: s.metrics[name] for name in METRICS}, seed)
    return {key: found[key] for key in ("lost_rate", "infeasible_rate", *METRICS)}


def show(found: dict[str, dict[str, dict[str, Any]]]) -> None:
    """Print one line a machine, and the whole."""
    table = Table(box=None)
    table.add_column("machine")
    judged_on = tuple(next(iter(found.values())))
    for suite in judged_on:
        for what in ("lost %", "infeasible %", "deviation %", "ripple %", "angle deg"):
            table.add_column(f"{suite}\n{what}", justify="right")
    for name, suites in found.items():
        cells = []
        for suite in judged_on:
            r = suites[suite]
            cells += [f"{100 * r['lost_rate']:.1f}", f"{100 * r['infeasible_rate']:.0f}"]
            cells += [f"{100 * r[m]:.2f}" for m in METRICS[:2]] + [f"{r[METRICS[2]]:.1f}"]
        table.add_row(name, *cells)
    console = Console(width=150)
    console.print(table)
    for suite in judged_on:
        lost = np.array([r[suite]["lost_rate"] for r in found.values()])
        geo = [np.exp(np.mean(np.log([r[suite][m] for r in found.values()]))) for m in METRICS]
        console.print(
            f"{suite}: lost median {100 * np.median(lost):.2f} %, mean {100 * lost.mean():.2f} %, "
            f"at most 1 % on {np.sum(lost <= 0.01)} of {len(lost)}; geometric means: deviation "
            f"{100 * geo[0]:.2f} %, ripple {100 * geo[1]:.2f} %, angle {geo[2]:.2f} degrees"
        )


def main() -> None:
    """Judge all machines and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE")
    parser.add_argument("--motor", nargs="+", default=[], help="more machines")
    parser.add_argument("--family", type=int, default=24, help="random machines")
    parser.add_argument("--family-seed", type=a_seed, default=5)
    parser.add_argument("--suite", nargs="+", default=SUITES, choices=tuple(KNOWN), metavar="NAME")
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument("--size", type=a_count, default=200)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    check_writable(args.out)
    design = design_from(args.set)
    motors = [Motor.load(path.stem) for path in sorted(MOTORS.glob("*.toml"))]
    motors += [Motor.load(name) for name in args.motor]
    motors += family(args.family_seed, args.family) if args.family else ()
    found = {
        motor.name: {s: judged(motor, design, s, args.seed, args.size) for s in args.suite}
        for motor in motors
    }
    show(found)
    if args.out:
        facts = {"family": NAME, "family_seed": args.family_seed, "seed": args.seed}
        facts |= {"size": args.size, "set": args.set, "versions": versions()}
        write_record(args.out, {**facts, "machines": found})


if __name__ == "__main__":
    in_one_line(main)

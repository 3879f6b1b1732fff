"""How often the check at first power-up finds each mistake, and how often it is wrong.

    python studies/bring_up_study.py

Shipped machines and random ones of the family, each on drives with the errors of the suite
`stress`. A mistake counts as found if a bit that names it is set. Compensation in the driver is
counted only on machines whose dead time the check judges.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.records import bring_up_record
from sensorless.envs.scenarios.machine_family import NAME, family
from sensorless.errors import in_one_line
from sensorless.files import check_writable, write_record
from sensorless.identify.bring_up.survey import count_pole_pairs, survey, turning_drive
from sensorless.machine.motor import MOTORS, Motor
from sensorless.versions import versions

COUNTED = ("drives", "flagged", "named")
"""What a record counts of a mistake."""


def counted(motors: Sequence[Motor], seed: int, size: int) -> dict[str, Any]:
    """Drives, flagged and named, by mistake, over all machines; and pole pairs."""
    total: dict[str, list[int]] = {}
    pairs = 0
    for motor in motors:
        judged = float(bring_up_record(motor)["u_lost"]) > 0.0
        for name, n in survey(motor, np.arange(seed, seed + size, dtype=np.uint64)):
            if judged or not name.startswith("compensated"):
                row = total.setdefault(name, [0, 0, 0])
                for j, number in enumerate((n.drives, n.flagged, n.named)):
                    row[j] += number
        pairs += count_pole_pairs(turning_drive(motor, seed)) == motor.n_p
    counts = {name: dict(zip(COUNTED, row, strict=True)) for name, row in total.items()}
    return {"machines": len(motors), "pole_pairs_right": pairs, "built_in": counts}


def show(found: dict[str, Any]) -> None:
    """Print a line for each mistake."""
    for group in ("shipped", "random"):
        rows = found[group]
        print(
            f"{group}: {rows['machines']} machines, pole pairs right on {rows['pole_pairs_right']}"
        )
        for name, n in rows["built_in"].items():
            share = n["flagged"] if name == "right" else n["named"]
            print(f"  {name:24} {share:6} of {n['drives']}  {100.0 * share / n['drives']:6.2f} %")


def main() -> None:
    """Run and write the record."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=a_seed, default=1000, help="the first (default %(default)s)")
    parser.add_argument("--size", type=a_count, default=40, help="drives (default %(default)s)")
    parser.add_argument("--machines", type=a_count, default=96, help="random (default %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("results/studies/bring_up.json"))
    args = parser.parse_args()
    check_writable(args.out)
    found = {
        "seed": args.seed,
        "family": NAME,
        "shipped": counted(
            [Motor.load(path.stem) for path in sorted(MOTORS.glob("*.toml"))], args.seed, args.size
        ),
        "random": counted(family(args.seed, args.machines), args.seed, args.size),
        "versions": versions(),
    }
    show(found)
    write_record(args.out, found)


if __name__ == "__main__":
    in_one_line(main)

"""From a rule to a folder of C99: exported, self-tested, with --judge judged, and what to call.

    python examples/flash.py --out firmware_eq25
    cc -std=c99 -ffp-contract=off -fno-math-errno -fno-trapping-math -c firmware_eq25/core/*.c

The README of the folder has the same calls with its own numbers.
"""

import argparse
from pathlib import Path

from sensorless.design.drive import DriveDesign
from sensorless.errors import in_one_line
from sensorless.export.export import export, table_of
from sensorless.export.judge import judge_export, verdict
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

CALLS = """
drive_init, ks_schedule_init   once, at power-up
drive_find_rotor               once, behind drive_init, if DRIVE_FINDS_ROTOR of params.h is 1
ks_schedule_step, drive_step   every PWM period, with two currents, the link and the speed wanted
drive.fault, schedule.fault    read after it; bits stay set until you clear them"""


def main(words: list[str] | None = None) -> None:
    """Export Eq. 25, or any rule that is a table, or a training run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policy", default="eq25", help="rule, tuned file, or run")
    parser.add_argument("--out", type=Path, default=Path("firmware_eq25"), help="new folder")
    parser.add_argument("--judge", action="store_true", help="run 900 scenarios before: seconds")
    given = parser.parse_args(words)

    motor = Motor.load("paper")
    policy = make_policy(given.policy, motor)
    design = DriveDesign(**policy.settings)
    judged = judge_export(policy, motor, design) if given.judge else None
    print(f"verdict: {verdict(judged)}")
    table = table_of(policy, given.policy)
    done = export(table, motor, design, given.out, policy=policy.name, judged=judged)
    print(f"wrote {len(done.files)} files to {done.folder}\n{done.self_test.message}\n{CALLS}")


if __name__ == "__main__":
    in_one_line(main)

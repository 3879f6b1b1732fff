"""Replay a log of currents and voltages: what each observer would have said, beside the encoder.

Without a file it takes the log that comes with the package. docs/replay.md names the columns.

    python examples/replay_a_log.py
    python examples/replay_a_log.py bench.csv --motor mine.toml
"""

import argparse
from pathlib import Path

from sensorless.design.drive import DriveDesign
from sensorless.errors import in_one_line
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.replay.replay import SAMPLE, load, replay


def main(words: list[str] | None = None) -> None:
    """Print the angle error of every estimator on the coupled and on the paper's observers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log", nargs="?", type=Path, default=SAMPLE, help="log to replay")
    parser.add_argument("--motor", default="paper", help="shipped motor, or a motor file")
    parser.add_argument("--after", type=float, default=0.05, help="count errors from here on [s]")
    given = parser.parse_args(words)

    motor = Motor.load(given.motor)
    for estimator in ("coupled", "smo"):
        design = DriveDesign(estimator=estimator)
        log = load(given.log, motor, design)
        found = replay(log, motor, design, make_policy("eq25", motor))
        print(f"estimator={estimator}, {len(log.t)} samples")
        for name, row in found.summary(given.after).items():
            if row["share"] > 0.0:  # of the samples, those with a signal of its own
                print(f"  {found.label(name):16} {row['rms_deg']:6.2f}° RMS, {row['share']:.0%}")


if __name__ == "__main__":
    in_one_line(main)

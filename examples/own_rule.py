"""A hand-over rule of your own beside Eq. 25, the ramp of the speed from the source paper.

A rule sees only what firmware measures or estimates (``sensorless.envs.signals``) and gives the
weight k_s of injection: 1 is all of it. This one asks for injection at low speed, as Eq. 25 does,
and up to twice as far where the torque current is high: under load the observer is the poorer one.

    python examples/own_rule.py --size 400

Any command takes it, too: --policy examples.own_rule:MoreUnderLoad.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from sensorless.design.drive import DriveDesign
from sensorless.envs.signals import SIGNALS
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import NO_SETTINGS

NAMES = [signal.name for signal in SIGNALS]
SPEED, CURRENT = NAMES.index("speed"), NAMES.index("torque_current")


class MoreUnderLoad:
    """Ramp of the speed whose band moves up with the torque current."""

    name = "more-under-load"
    sensored = False
    settings = NO_SETTINGS  # for example {"estimator": "smo"}

    def __init__(self, motor: Motor) -> None:
        """Nothing of the machine is needed: all signals are shares of rated ones."""

    def reset(self, n: int) -> None:
        """There is nothing to forget: this rule has no memory."""

    def act(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weights (n,) at the signals (n, 12); speeds over rated speed, currents over rated."""
        start = 0.2 * (1.0 + np.clip(np.abs(obs[:, CURRENT]), 0.0, 1.0))
        k_s = np.clip((start + 0.1 - obs[:, SPEED]) / 0.1, 0.0, 1.0)
        return np.asarray(k_s, dtype=np.float32)


def main(words: list[str] | None = None) -> None:
    """Judge the rule and print how it did."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=400, help="scenarios")
    size = parser.parse_args(words).size

    motor = Motor.load("paper")
    policies = {"eq25": make_policy("eq25", motor), MoreUnderLoad.name: MoreUnderLoad(motor)}
    results = evaluate(motor, DriveDesign(), "stress-1", seed=7, size=size, policies=policies)
    for name, found in results.policies.items():
        deviation, lost = 100.0 * found["torque_dev_rms"], 100.0 * found["lost_rate"]
        print(f"{name:16} lost {lost:.1f} %, torque deviation {deviation:.2f} %")


if __name__ == "__main__":
    in_one_line(main)

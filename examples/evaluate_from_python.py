"""Judge rules from Python: rates with intervals, differences in pairs, the worst case again.

For example:

    python examples/evaluate_from_python.py --size 400
"""

import argparse

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import scenario_from
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.trace import outcome, trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import design_for


def main(words: list[str] | None = None) -> None:
    """Compare two rules with Eq. 25 on the paper's observers."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=400, help="scenarios")
    size = parser.parse_args(words).size

    motor, design = Motor.load("paper"), DriveDesign()
    names = ("sliding_mode", "eq25", "reference")  # the first one is what the others are beside
    policies = {name: make_policy(name, motor) for name in names}
    results = evaluate(motor, design, "stress-1", 7, size, policies)

    for name, found in results.policies.items():
        low, high = (100.0 * edge for edge in found["lost_ci"])
        print(
            f"{name:14} lost {100.0 * found['lost_rate']:.1f} % ({low:.1f} to {high:.1f} %), "
            f"torque deviation {100.0 * found['torque_dev_rms']:.2f} %"
        )
    for name, pair in results.paired.items():
        low, high = (100.0 * edge for edge in pair["torque_dev_rms_ci"])
        change = 100.0 * pair["torque_dev_rms"]
        print(f"{name:14} deviates by {change:+.2f} points ({low:+.2f} to {high:+.2f})")

    # Every scenario has a word that runs it again, here period by period.
    word = results.policies["sliding_mode"]["worst"][0]["scenario"]
    for name, policy in policies.items():
        case = scenario_from(word, motor)
        run = trace(policy, case, motor, design_for(policy, design))
        print(f"{word} under {name}: {outcome(run)} after {run['t'][-1]:.2f} s")


if __name__ == "__main__":
    in_one_line(main)

"""What each error of sensors and inverter costs: a suite again without it.

    python studies/error_budget.py --suite stress-1 --seed 11 --size 1000
    python studies/error_budget.py --suite unload --seed 21 --policy ppo-coupled

The policy and the sensored drive run the same scenarios; a row leaves out what it names. Ripple and
deviation are means over the scenarios survived, the angle error is the largest of all of them.
"""

import argparse
from dataclasses import replace

import numpy as np

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.rollout import rollout, with_twin_to_the_end
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

WITHOUT: tuple[tuple[str, ...], ...] = (
    (), ("offset",), ("gain",), ("offset", "gain"), ("noise",), ("dead_time",),
    ("dead_time", "R_s", "winding_K", "psi_f", "magnet_K"),
)  # fmt: skip
"""Errors that a row leaves out: ratios are 1, others 0, the dead time is the motor file's; without
``winding_K`` and ``magnet_K`` the machine is as warm as the file's."""
NO_DEAD_TIME = "any dead time, R_s, ..."
"""Last row: the same, but the inverter has no dead time and the drive compensates none. Not for a
policy that brings settings of its own."""
SHOWN = ("torque_ripple_rms", "torque_dev_rms")


def main() -> None:
    """Read the words of the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motor", default="paper")
    parser.add_argument("--suite", default="stress-1")
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument("--size", type=a_count, default=1000)
    parser.add_argument("--policy", default="eq25")
    parser.add_argument("--estimator", choices=ESTIMATORS, default=DriveDesign().estimator)
    args = parser.parse_args()
    try:
        table(args)
    except UserError as error:
        parser.error(str(error))


def table(args: argparse.Namespace) -> None:
    """Run and print a row for each of ``WITHOUT``, and one without dead time."""
    motor = Motor.load(args.motor)
    design = DriveDesign(estimator=args.estimator)
    exact = {"gain": 1.0, "dead_time": motor.dead_time, "R_s": 1.0, "psi_f": 1.0}
    what = "ripple, deviation [%], angle [deg]"
    print(f"{'without':23}" + "     ".join(f"{p} {what}" for p in (args.policy, "sensored")))
    for names in WITHOUT:
        scenarios = SuiteRows(args.suite, motor, args.seed, args.size).draw()
        for name in names:
            getattr(scenarios, name)[:] = exact.get(name, 0.0)
        row(", ".join(names) or "nothing", scenarios, motor, design, args.policy)
    if make_policy(args.policy, motor).settings:
        return
    scenarios.dead_time[:] = 0.0
    row(NO_DEAD_TIME, scenarios, motor, replace(design, dead_time_share=0.0), args.policy)


def row(name: str, scenarios: Scenarios, motor: Motor, design: DriveDesign, policy: str) -> None:
    """Run the scenarios under the policy and with a sensor, and print what is shown of both."""
    factory = SimFactory(motor, design)
    columns = []
    for p in (make_policy(policy, motor), make_policy("sensored", motor)):
        r = with_twin_to_the_end(rollout(p, scenarios, factory), factory, p.settings)
        kept = r.lost == 0
        shown = [100.0 * np.mean(METRICS[m](r)[kept]) for m in SHOWN]
        shown.append(np.max(METRICS["angle_err_max_deg"](r)[kept], initial=0.0))
        columns.append("  ".join(f"{x:6.2f}" for x in shown) + f"  {np.sum(~kept)} lost")
    print(f"{name:23}" + "     ".join(columns), flush=True)


if __name__ == "__main__":
    main()

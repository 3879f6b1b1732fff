"""What each error of sensors and inverter costs: a suite again without it.

    python studies/error_budget.py --suite stress-1 --seed 11 --size 1000

Eq. 25 and the sensored drive run the same scenarios; a row leaves out what it names.
"""

import argparse

import numpy as np

from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.rollout import rollout, with_twin_to_the_end
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

WITHOUT: tuple[tuple[str, ...], ...] = (
    (), ("offset",), ("gain",), ("offset", "gain"), ("noise",), ("dead_time",)
)  # fmt: skip
"""Errors that a row leaves out: channel gains are 1, the dead time is the motor file's."""
SHOWN = ("torque_ripple_rms", "torque_dev_rms")


def main() -> None:
    """Read the words of the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motor", default="paper")
    parser.add_argument("--suite", default="stress-1")
    parser.add_argument("--seed", type=int, default=11)
    parser.add_argument("--size", type=int, default=1000)
    parser.add_argument("--estimator", choices=ESTIMATORS, default=DriveDesign().estimator)
    args = parser.parse_args()
    try:
        table(args)
    except UserError as error:
        parser.error(str(error))


def table(args: argparse.Namespace) -> None:
    """Run and print a row for each of ``WITHOUT``."""
    motor = Motor.load(args.motor)
    factory = SimFactory(motor, DriveDesign(estimator=args.estimator))
    exact = {"gain": 1.0, "dead_time": motor.dead_time}
    print(
        f"{'without':14}  " + "  ".join(f"{p} ripple, deviation [%]" for p in ("eq25", "sensored"))
    )
    for names in WITHOUT:
        scenarios = SuiteRows(args.suite, motor, args.seed, args.size).draw()
        for name in names:
            getattr(scenarios, name)[:] = exact.get(name, 0.0)
        columns = []
        for policy in (make_policy(p, motor) for p in ("eq25", "sensored")):
            r = with_twin_to_the_end(rollout(policy, scenarios, factory), factory, policy.settings)
            means = [100.0 * np.mean(METRICS[name](r)[r.lost == 0]) for name in SHOWN]
            columns.append("  ".join(f"{x:6.2f}" for x in means) + f"  {np.sum(r.lost != 0)} lost")
        print(f"{', '.join(names) or 'nothing':14}  " + "     ".join(columns), flush=True)


if __name__ == "__main__":
    main()

"""What a drive with some gains does: its cost, its exactness, and how fast its speed follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.evaluation.compare import Outcomes
from sensorless.evaluation.metrics.catalogue import angle_err_rms_deg, torque_dev_rms
from sensorless.evaluation.metrics.held import not_held
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.metrics.step import dip_pct_s, settling_twin_s
from sensorless.evaluation.objective import LOST_WEIGHT, Cost, cost_of
from sensorless.evaluation.rates import Bools
from sensorless.evaluation.rollout import Floats, are_feasible, rollouts, with_twin_to_the_end
from sensorless.machine.motor import Motor
from sensorless.policy import Policy

KEPT = {
    "angle error": angle_err_rms_deg,
    "dip": dip_pct_s,
    "settling": settling_twin_s,
}
"""Means that may not rise over the start's: RMS angle error, dip of the speed after a load step,
and settling time of the sensored twin, which has the same speed loop."""
METRICS = {
    "torque_dev": torque_dev_rms,
    "torque_ripple": torque_ripple_rms,
    "not_held": not_held,
    **KEPT,
}
PRICE = 1.0
"""Added to the objective for each of ``KEPT`` that is one time the start's too large."""


@dataclass(frozen=True)
class Measured:
    """A drive on n scenarios."""

    feasible: Bools
    """(n,) the sensored twin did what the scenario asks for"""
    lost: Bools
    """(n,) drive or twin was"""
    numbers: Mapping[str, Floats]
    """(n,) of each of ``METRICS``"""

    def outcomes(self) -> Outcomes:
        """What ``comparison`` compares."""
        kept = ~self.lost
        dev, ripple = (
            np.where(kept, self.numbers[name], 0.0) for name in ("torque_dev", "torque_ripple")
        )
        return Outcomes(self.feasible, self.lost & self.feasible, dev, ripple)


def joined(parts: Sequence[Measured]) -> Measured:
    """Several suites as one set of scenarios."""
    return Measured(
        np.concatenate([p.feasible for p in parts]),
        np.concatenate([p.lost for p in parts]),
        {name: np.concatenate([p.numbers[name] for p in parts]) for name in METRICS},
    )


def measure(motor: Motor, design: DriveDesign, policy: Policy, scenarios: Scenarios) -> Measured:
    """Run a drive over all scenarios."""
    factory = SimFactory(motor, design)
    runs = [with_twin_to_the_end(r, factory) for r in rollouts(policy, scenarios, factory)]
    lost = np.concatenate([r.lost for r in runs])
    return Measured(
        are_feasible(lost),
        lost != 0,
        {name: np.concatenate([metric(r) for r in runs]) for name, metric in METRICS.items()},
    )


def cost(found: Measured, start: Measured) -> Cost:
    """Cost where the start's twin is feasible: gains at which a twin fails there lose."""
    torques = (found.numbers[name] for name in ("torque_dev", "torque_ripple"))
    return cost_of(found.lost, start.feasible, *torques)


def not_held_rate(found: Measured, start: Measured) -> float:
    """Share of the feasible scenarios whose speed swings or stays away, though lock was kept."""
    loose = start.feasible & ~found.lost & (found.numbers["not_held"] > 0.0)
    return float(loose.sum() / max(int(start.feasible.sum()), 1))


def pairs(name: str, found: Measured, start: Measured) -> tuple[Floats, Floats]:
    """A metric where both drives survived and have it: of these gains, and of the start."""
    ours, theirs = found.numbers[name], start.numbers[name]
    both = ~found.lost & ~start.lost & np.isfinite(ours) & np.isfinite(theirs)
    return ours[both], theirs[both]


def rise(name: str, found: Measured, start: Measured) -> float:
    """Mean of one of ``KEPT`` over the start's, minus 1; 0 where neither has it."""
    ours, theirs = pairs(name, found, start)
    return float(ours.mean() / theirs.mean() - 1.0) if len(ours) and theirs.mean() > 0.0 else 0.0


def excess(found: Measured, start: Measured, margin: float = 0.0) -> float:
    """How much less these gains keep than the start, in units of the objective; 0: nothing.

    What is not held counts where both kept lock: a drive that only swings is no worse than lost.
    ``margin`` is what each of ``KEPT`` has to be better than the start's.
    """
    both = start.feasible & ~start.lost & ~found.lost
    ours, theirs = (both & (x.numbers["not_held"] > 0.0) for x in (found, start))
    loose = max(0, int(ours.sum()) - int(theirs.sum())) / max(int(start.feasible.sum()), 1)
    slack = sum(max(0.0, rise(name, found, start) + margin) for name in KEPT)
    return LOST_WEIGHT * loose + PRICE * slack

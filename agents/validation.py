"""Cost of a policy on scenarios that neither training nor judging uses."""

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.objective import Cost
from sensorless.evaluation.rollout import rollouts
from sensorless.policy import Policy

SUITE = "stress-1"
"""Suite of validation, and of the states that distillation visits."""


def validate(policy: Policy, factory: SimFactory, size: int, seed: int = 0) -> Cost:
    """Cost of a policy over ``size`` scenarios of ``SUITE`` with the role ``tune``."""
    scenarios = suite(SUITE, factory.motor, seed, size, role="tune")
    lost, dev, ripple = [], [], []
    for r in rollouts(policy, scenarios, factory):
        kept = r.lost == 0
        lost.append(~kept)
        dev.append(torque_dev_rms(r)[kept])
        ripple.append(torque_ripple_rms(r)[kept])
    means = (float(np.mean(np.concatenate(x))) if sum(map(len, x)) else 1.0 for x in (dev, ripple))
    return Cost(float(np.mean(np.concatenate(lost))), *means)


def validate_all(policy: Policy, factories: Sequence[SimFactory], size: int) -> Cost:
    """Mean cost over machines that divide ``size`` scenarios among them, rounded up."""
    share = -(-size // len(factories))
    costs = [validate(policy, factory, share, seed) for seed, factory in enumerate(factories)]
    return Cost(*(float(np.mean(part)) for part in zip(*map(astuple, costs), strict=True)))

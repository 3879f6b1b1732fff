"""Cost of a policy on scenarios that neither training nor judging uses."""

from collections.abc import Sequence
from dataclasses import astuple

import numpy as np

from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.compare import ended
from sensorless.evaluation.objective import Cost
from sensorless.policy import Policy

SUITE = "stress-1"
"""Suite of validation, and of the states that distillation visits."""


def validate(policy: Policy, factory: SimFactory, size: int, seed: int = 0) -> Cost:
    """Cost of a policy over ``size`` scenarios of ``SUITE`` with the role ``tune``."""
    scenarios = suite(SUITE, factory.motor, seed, size, role="tune")
    found = ended(policy, [(factory, scenarios)])
    return found.cost(found.feasible)


def validate_all(policy: Policy, factories: Sequence[SimFactory], size: int) -> Cost:
    """Mean cost over machines that divide ``size`` scenarios among them, rounded up."""
    share = -(-size // len(factories))
    costs = [validate(policy, factory, share, seed) for seed, factory in enumerate(factories)]
    return Cost(*(float(np.mean(part)) for part in zip(*map(astuple, costs), strict=True)))

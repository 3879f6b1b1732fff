"""Scenarios of a suite, cut short where only their number and order count."""

from collections.abc import Callable

from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.motor import Motor


def lasting(seconds: float) -> Callable[..., Scenarios]:
    """In place of ``suite``: the same scenarios, each for so long [s]."""

    def short(name: str, motor: Motor, seed: int, size: int, role: str = "test") -> Scenarios:
        scenarios = suite(name, motor, seed, size, role)
        scenarios.duration[:] = seconds
        return scenarios

    return short

"""Scenarios of a suite, cut short where only their number and order count."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.suites import SuiteRows, suite
from sensorless.machine.motor import Motor
from sensorless.pil.scenarios import pil_scenarios


@contextmanager
def briefly() -> Iterator[None]:
    """Training validates, and distilling samples, on scenarios of 0.2 s."""
    with pytest.MonkeyPatch.context() as patch:
        for module in ("agents.distill", "evaluation.validation"):
            patch.setattr(f"sensorless.{module}.suite", lasting(0.2))
        yield


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Scenarios of every suite end after so long [s], however they are asked for."""
    whole = SuiteRows.draw

    def draw(rows: SuiteRows) -> Scenarios:
        scenarios = whole(rows)
        scenarios.duration[:] = np.minimum(scenarios.duration, seconds)
        return scenarios

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(SuiteRows, "draw", draw)
        yield


def on_the_target(seconds: float) -> Callable[..., tuple[tuple[str, ...], Scenarios]]:
    """In place of ``pil_scenarios``: the same scenarios, each for so long [s]."""

    def short(motor: Motor, seed: int, size: int) -> tuple[tuple[str, ...], Scenarios]:
        names, scenarios = pil_scenarios(motor, seed, size)
        scenarios.duration[:] = seconds
        return names, scenarios

    return short


def cut(draw: Callable[..., Scenarios], seconds: float) -> Callable[..., Scenarios]:
    """The same scenarios, each for so long [s]."""

    def short(*words: Any, **more: Any) -> Scenarios:
        scenarios = draw(*words, **more)
        scenarios.duration[:] = seconds
        return scenarios

    return short


def lasting(seconds: float) -> Callable[..., Scenarios]:
    """In place of ``suite``: the same scenarios, each for so long [s]."""
    return cut(suite, seconds)

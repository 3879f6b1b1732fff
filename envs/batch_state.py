"""Copy of all that a batch of drives remembers, and of the settings that it is valid for."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from sensorless.core.api import Array
from sensorless.envs.blend_settings import BlendSettings
from sensorless.envs.counter_random import Seeds
from sensorless.envs.privileged import Values
from sensorless.errors import UserError, shown
from sensorless.machine.motor import Motor


@dataclass(frozen=True)
class BatchState:
    """Copy of all that a batch remembers."""

    made: Mapping[str, Any]
    """``made_on`` of the batch"""
    sims: Array
    constant: Values
    seeds: Seeds
    episode: Seeds
    gains: Array | None
    window: Array | None
    """Sums of the reward's window, oldest first"""


def made_on(n: int, motor: Motor, settings: BlendSettings) -> dict[str, Any]:
    """What must be equal, by name, where a state is restored."""
    draw, weights = settings.scenarios, settings.weights
    if not isinstance(draw, str):
        draw = f"{draw.__module__}.{getattr(draw, '__qualname__', type(draw).__qualname__)}"
    return {
        "num_envs": n,
        "motor": f"{motor.name}, digest {motor.digest[:16]}",
        "scenarios": draw,
        "decision_period": settings.decision_period,
        "max_episode_steps": settings.max_episode_steps,
        "gains": settings.ranges,
        "weights": type(weights).__name__,
        **{f"weights.{name}": value for name, value in asdict(weights).items()},
        **asdict(settings.design),
    }


def checked_state(state: object, made: Mapping[str, Any]) -> BatchState:
    """Return a state to restore in a batch ``made`` so.

    Raises
    ------
    UserError
        It is no state, or of a batch that was made otherwise.
    """
    if not isinstance(state, BatchState):
        raise UserError(f"state: {shown(state)}; restore what state() gave")
    for name, own in made.items():
        then = state.made.get(name)
        if then != own:
            raise UserError(
                f"state: {name}: it was made with {shown(then)}, this environment with "
                f"{shown(own)}; restore it where they are equal"
            )
    return state

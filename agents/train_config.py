"""What a training run is made with; command line and ``config.json`` are this dataclass."""

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.core_api import SIGNAL_N, SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.ks_table import Axis, KsTable
from sensorless.motor import Motor


def _number(default: Any, low: float, high: float) -> Any:
    return field(default=default, metadata={"low": low, "high": high})


@dataclass(frozen=True)
class TrainConfig:
    """Settings of PPO on the table policy."""

    motor: str = "paper"
    """shipped motor by name, or a TOML file"""
    minutes: float = _number(5.0, 0.0, 1e5)
    """time to train [min]; ends earlier after `steps`"""
    steps: int = _number(10**9, 1, 10**12)
    """decisions to train, over all environments"""
    seed: int = _number(1, 0, 2**32 - 1)
    """of scenarios, exploration and critic"""
    axes: str = "speed:0:1:16,torque_current:-1.5:1.5:5"
    """SIGNAL:LOW:HIGH:NODES of every axis of the table, commas between"""
    start: str = "eq25"
    """schedule to start from: eq25 or linear:LO,HI [r/min], LO and HI on nodes"""
    n_envs: int = _number(256, 1, 65536)
    """environments side by side"""
    n_steps: int = _number(32, 2, 65536)
    """decisions of each between two updates"""
    batch_size: int = _number(4096, 2, 10**7)
    """samples of a gradient step"""
    n_epochs: int = _number(4, 1, 100)
    """passes over the samples an update"""
    gamma: float = _number(0.993, 0.0, 1.0)
    """discount a decision; the horizon must see the 50 to 200 ms that losing lock takes"""
    gae_lambda: float = _number(0.95, 0.0, 1.0)
    """trade of bias and variance in the advantages"""
    lr_nodes: float = _number(5e-3, 1e-6, 1.0)
    """step of Adam on the table's nodes"""
    lr_critic: float = _number(1e-3, 1e-6, 1.0)
    """step of Adam on the critic"""
    clip_range: float = _number(0.2, 0.01, 1.0)
    """bound on the probability ratio of an update"""
    noise: float = _number(0.1, 1e-3, 1.0)
    """standard deviation of the exploration in k_s; it persists over a rollout"""
    smoothness: float = _number(2.0, 0.0, 10.0)
    """distance over which neighbouring nodes explore and move together [nodes]"""
    average: int = _number(20, 1, 10**6)
    """updates whose mean table is validated and kept"""
    warm_up: int = _number(5, 0, 10**6)
    """updates of the critic alone before the table moves"""
    decision_ms: float = _number(5.0, 0.1, 100.0)
    """time between two decisions in training [ms]"""
    lost_penalty: float = _number(150.0, 0.0, 1e6)
    """reward lost with lock; must exceed the running cost over the whole horizon"""
    validate_seconds: float = _number(20.0, 1.0, 1e6)
    """training time between two validations [s]"""
    validate_size: int = _number(512, 16, 10**6)
    """scenarios of a validation, from seeds that neither training nor tests use"""

    def __post_init__(self) -> None:
        """Check every number.

        Raises
        ------
        UserError
            Names the field, its value and what is allowed.
        """
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            if "low" not in f.metadata:
                continue
            low, high = f.metadata["low"], f.metadata["high"]
            if not (math.isfinite(value) and low <= value <= high):
                raise UserError(f"{f.name}: {value!r}; allowed: {low:g} to {high:g}")

    def start_table(self, motor: Motor, slew_per_s: float) -> KsTable:
        """Return the table training starts from: an exact copy of the linear rule.

        Raises
        ------
        UserError
            Bad words in ``axes`` or ``start``, or a ramp with an end between two nodes.
        """
        axes = _axes(self.axes)
        low, high = _band(self.start, motor)
        speed = next((a for a in axes if a.signal == "speed"), None)
        if speed is None:
            raise UserError(f"axes: {self.axes!r}; allowed: with an axis of speed")
        nodes = np.linspace(speed.lo, speed.hi, speed.n)
        for end in (low, high):
            if np.min(np.abs(nodes - end)) > 1e-3 * (nodes[1] - nodes[0]):
                near = ", ".join(f"{x * motor.n_rated_rpm:g}" for x in nodes)
                raise UserError(
                    f"start: {self.start!r}: {end * motor.n_rated_rpm:g} r/min is no node of "
                    f"the speed axis; allowed: {near}"
                )
        obs = np.zeros((speed.n, SIGNAL_N), dtype=np.float32)
        obs[:, SIGNAL_NAMES.index("speed")] = nodes
        ramp = np.round(linear_table(low, high).evaluate(obs), 5)
        shape = [1] * len(axes)
        shape[axes.index(speed)] = speed.n
        values = np.broadcast_to(ramp.reshape(shape), [a.n for a in axes])
        return KsTable(axes, np.ascontiguousarray(values), slew_per_s=slew_per_s)


def _axes(text: str) -> tuple[Axis, ...]:
    try:
        words = [word.split(":") for word in text.split(",")]
        return tuple(Axis(name, float(lo), float(hi), int(n)) for name, lo, hi, n in words)
    except ValueError as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"axes: {text!r}; allowed: SIGNAL:LOW:HIGH:NODES,...") from None


def _band(text: str, motor: Motor) -> tuple[float, float]:
    """Ends of the ramp over rated speed."""
    if text == "eq25":
        return EQ25_BAND
    name, _, numbers = text.partition(":")
    try:
        low, high = (float(x) / motor.n_rated_rpm for x in numbers.split(","))
    except ValueError:
        low, high = 1.0, 0.0
    if name != "linear" or not 0.0 <= low < high:
        raise UserError(f"start: {text!r}; allowed: eq25, linear:LO,HI with 0 <= LO < HI [r/min]")
    return low, high

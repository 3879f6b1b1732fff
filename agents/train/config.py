"""What a training run is made with; command line and ``config.json`` are this dataclass."""

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

from sensorless.agents.table.start import start_table
from sensorless.envs.scenarios.machine_family import MOST
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable

KINDS = ("table", "mlp")


def _number(default: Any, low: float, high: float) -> Any:
    return field(default=default, metadata={"low": low, "high": high})


@dataclass(frozen=True)
class TrainConfig:
    """Settings of PPO."""

    motor: str = "paper"
    """shipped motor by name, or a TOML file"""
    machines: int = _number(0, 0, MOST)
    """train over so many random machines, drawn from the seed, instead of the motor, which then
    only turns r/min of a start into shares of rated speed; the schedule fits any machine; 0: the
    motor alone"""
    minutes: float = _number(5.0, 0.0, 1e5)
    """time to train [min]; not repeatable, see `steps`"""
    steps: int = _number(0, 0, 10**12)
    """decisions to train, over all environments, whatever time that takes; repeatable to the bit;
    0: train for `minutes`"""
    seed: int = _number(1, 0, 2**32 - 1)
    """of scenarios, exploration and critic"""
    policy_kind: str = "table"
    """what chooses k_s: table, or mlp, a network over all signals (see sensorless distill)"""
    axes: str = "speed:0:1:16,disagreement:-1.5:1.5:5"
    """SIGNAL:LOW:HIGH:NODES of every axis of the table, commas between; speed:NODES puts nodes at
    the ends of a linear start; the word start takes the axes of the start"""
    start: str = "eq25"
    """schedule to start from: eq25, linear:LO,HI [r/min], a file of tune, or a run folder"""
    n_envs: int = _number(256, 2, 65536)
    """environments side by side; even: they come in pairs of opposite exploration"""
    n_steps: int = _number(400, 2, 65536)
    """decisions of each between two updates; 400 of 5 ms are a whole scenario, and what starts and
    ends with it needs no guess of the critic"""
    batch_size: int = _number(12800, 2, 10**7)
    """samples of a gradient step"""
    n_epochs: int = _number(2, 1, 100)
    """passes over the samples an update"""
    gamma: float = _number(0.9995, 0.0, 1.0)
    """discount a decision; a scenario counts as a whole"""
    gae_lambda: float = _number(1.0, 0.0, 1.0)
    """trade of bias and variance in the advantages; below 1 what comes late counts less"""
    lr_nodes: float = _number(1e-2, 1e-6, 1.0)
    """step of Adam on the table's nodes"""
    lr_critic: float = _number(1e-3, 1e-6, 1.0)
    """step of Adam on the critic, and on the actor of an mlp"""
    lr_end: float = _number(0.05, 0.0, 1.0)
    """share of both steps that is left at the end, on a straight line from all of them"""
    clip_range: float = _number(0.2, 0.01, 1.0)
    """bound on the probability ratio of an update"""
    noise: float = _number(0.1, 1e-3, 1.0)
    """standard deviation of the exploration in k_s; it persists over a rollout"""
    smoothness: float = _number(2.0, 0.0, 10.0)
    """distance over which neighbouring nodes explore and move together [nodes]"""
    monotone: bool = False
    """keep k_s from rising with speed"""
    average: int = _number(5, 1, 10**6)
    """updates whose mean table is validated and kept"""
    warm_up: int = _number(2, 0, 10**6)
    """updates of the critic alone before the table moves"""
    decision_ms: float = _number(5.0, 0.1, 100.0)
    """time between two decisions in training [ms]"""
    lost_penalty: float = _number(1000.0, 0.0, 1e6)
    """reward lost with lock; must exceed the running costs that it ends: 151 in a scenario of 2 s
    at the very worst, without those of the angle"""
    angle_cost: float = _number(1.0, 0.0, 10.0)
    """cost per 1 ms of an angle error at which lock is lost; it begins at 20 degrees"""
    eval_freq: int = _number(500_000, 1, 10**12)
    """decisions, over all environments, from one validation to the next"""
    validate_size: int = _number(1024, 16, 10**6)
    """scenarios of a validation, from seeds that neither training nor tests use"""

    def __post_init__(self) -> None:
        """Check every number.

        Raises
        ------
        UserError
            Names the field, its value and what is allowed.
        """
        if self.policy_kind not in KINDS:
            raise UserError(f"policy_kind: {self.policy_kind!r}; allowed: {', '.join(KINDS)}")
        if self.monotone and self.policy_kind != "table":
            raise UserError("monotone: True; allowed with policy_kind table")
        if self.n_envs % 2:
            raise UserError(f"n_envs: {self.n_envs}; allowed: an even number")
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            if "low" not in f.metadata:
                continue
            low, high = f.metadata["low"], f.metadata["high"]
            if not (math.isfinite(value) and low <= value <= high):
                raise UserError(f"{f.name}: {value!r}; allowed: {low:g} to {high:g}")

        if 2 * self.machines > self.n_envs:
            raise UserError(
                f"machines: {self.machines}; allowed: up to half of n_envs = {self.n_envs}"
            )

    def start_table(self, source: KsTable, motor: Motor, slew_per_s: float) -> KsTable:
        """Return the table training starts from: ``source`` on the axes of this run."""
        return start_table(self.axes, self.start, source, motor, slew_per_s)

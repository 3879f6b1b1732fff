"""Settings of a training run: the options of the command and the content of ``config.json``."""

from dataclasses import dataclass

from sensorless.agents.table.start import start_table
from sensorless.decision import TRAINING
from sensorless.envs.scenarios.machine_family import MOST_MACHINES
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.settings import check, number, switch, word
from sensorless.table.ks_table import KsTable


@dataclass(frozen=True)
class TrainConfig:
    """Settings of PPO."""

    motor: str = word("paper", "shipped motor by name, or a TOML file")
    machines: int = number(
        0,
        "1",
        0,
        MOST_MACHINES,
        "train on so many random machines, drawn from the seed, instead of the motor, which then "
        "only turns r/min of a start into shares of rated speed; the schedule fits any machine; "
        "0: the motor alone",
    )
    minutes: float = number(5.0, "min", 0, 1e5, "time to train; not repeatable, see steps")
    steps: int = number(
        0,
        "1",
        0,
        10**12,
        "decisions to train, over all environments, whatever time that takes; repeatable to the "
        "bit; 0: train for minutes",
    )
    seed: int = number(1, "1", 0, 2**32 - 1, "draws scenarios, exploration and critic")
    policy_kind: str = word(
        "table",
        "what chooses k_s",
        {"table": "a table", "mlp": "a network over all signals (see sensorless distill)"},
    )
    axes: str = word(
        "speed:0:1:16,disagreement:-1.5:1.5:5",
        "SIGNAL:LOW:HIGH:NODES of every axis of the table, commas between; speed:NODES puts nodes "
        "at the ends of a linear start; the word start takes the axes of the start",
    )
    start: str = word(
        "eq25",
        "schedule to start from: eq25, linear:LO,HI [r/min], a file of sensorless tune, or a run "
        "folder",
    )
    n_envs: int = number(
        256,
        "1",
        2,
        65536,
        "environments side by side; even, as they are pairs that explore opposite ways",
    )
    n_steps: int = number(
        400,
        "1",
        2,
        65536,
        "decisions of each environment between two updates; 400 of 5 ms are a whole scenario, at "
        "whose time limit the critic's value stands for what would follow",
    )
    batch_size: int = number(12800, "1", 2, 10**7, "samples of a gradient step")
    n_epochs: int = number(2, "1", 1, 100, "passes over the samples an update")
    gamma: float = number(0.9995, "1", 0, 1, "discount a decision; a scenario counts as a whole")
    gae_lambda: float = number(
        1.0,
        "1",
        0,
        1,
        "trades bias against variance of the advantages; below 1, what comes late counts less",
    )
    lr_nodes: float = number(1e-2, "1", 1e-6, 1, "step of Adam on the table's nodes")
    lr_critic: float = number(
        1e-3, "1", 1e-6, 1, "step of Adam on the critic, and on the actor of an mlp"
    )
    lr_end: float = number(
        0.05, "1", 0, 1, "share of both steps that is left at the end; they fall on a straight line"
    )
    clip_range: float = number(0.2, "1", 0.01, 1, "bound on the probability ratio of an update")
    noise: float = number(
        0.1, "1", 1e-3, 1, "standard deviation of the exploration in k_s; it lasts for a rollout"
    )
    smoothness: float = number(
        2.0, "nodes", 0, 10, "distance over which neighbouring nodes explore and move together"
    )
    monotone: bool = switch(False, "keep k_s from rising with speed; tables only")
    average: int = number(5, "1", 1, 10**6, "updates whose mean table is validated and kept")
    warm_up: int = number(2, "1", 0, 10**6, "updates of the critic alone before the table moves")
    decision_ms: float = number(
        1e3 * TRAINING, "ms", 0.1, 100, "time between two decisions in training"
    )
    lost_penalty: float = number(
        1000.0,
        "1",
        0,
        1e6,
        "reward lost with lock; must exceed the running costs that it ends: 151 in a scenario of "
        "2 s at the very worst, without those of the angle",
    )
    angle_cost: float = number(
        1.0, "1/ms", 0, 10, "cost of an angle error at which lock is lost; it begins at 20 degrees"
    )
    eval_freq: int = number(
        500_000, "1", 1, 10**12, "decisions, over all environments, from one validation to the next"
    )
    validate_size: int = number(
        1024, "1", 16, 10**6, "scenarios of a validation, from seeds of neither training nor tests"
    )

    def __post_init__(self) -> None:
        """Check every setting, and those that depend on each other.

        Raises
        ------
        UserError
            Names the setting, its value and what it must be.
        """
        check(self)
        if self.monotone and self.policy_kind != "table":
            raise UserError("monotone: True: only a table can be: use policy_kind table")
        if self.n_envs % 2:
            raise UserError(f"n_envs: {self.n_envs}: must be even")
        if 2 * self.machines > self.n_envs:
            raise UserError(
                f"machines: {self.machines}: must be at most half of n_envs = {self.n_envs}"
            )

    def start_table(self, source: KsTable, motor: Motor, slew_per_s: float) -> KsTable:
        """Return the table training starts from: ``source`` on the axes of this run."""
        return start_table(self.axes, self.start, source, motor, slew_per_s)

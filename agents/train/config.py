"""Settings of a training run: the options of the command and the content of ``config.json``."""

from dataclasses import dataclass, replace

import numpy as np

from sensorless.agents.table.start import AXES, MARGIN, start_table
from sensorless.core.gains import DEFAULT, Gain, ranks
from sensorless.decision import TRAINING
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenarios.machine_family import MOST_MACHINES
from sensorless.envs.window_reward import WindowWeights
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.settings import check, number, switch, word
from sensorless.table.ks_table import GainGrid, KsTable


@dataclass(frozen=True)
class TrainConfig:
    """Settings of PPO."""

    motor: str = word(
        "paper", "train on this motor: the name of a shipped one, or your own TOML file"
    )
    machines: int = number(
        0,
        "1",
        0,
        MOST_MACHINES,
        "train on this many random machines, drawn from the seed, instead of the motor, which then "
        "only turns the r/min of --start into shares of rated speed; the schedule fits any "
        "machine; 0 trains on the motor alone",
    )
    minutes: float = number(
        5.0, "min", 0, 1e5, "train for this long; the result is not repeatable, that of --steps is"
    )
    steps: int = number(
        0,
        "1",
        0,
        10**12,
        "train for this many decisions, summed over all environments, and the rest of the update "
        "that they end in, whatever time that takes; the result is repeatable to the bit; 0 trains "
        "for --minutes",
    )
    seed: int = number(
        1, "1", 0, 2**32 - 1, "draw scenarios, exploration and critic from this seed"
    )
    policy_kind: str = word(
        "table",
        "let a policy of this kind choose k_s",
        {"table": "a table", "mlp": "a network over all signals (see sensorless distill)"},
    )
    axes: str = word(
        AXES,
        "give the table these axes, SIGNAL:LOW:HIGH:NODES,...; speed:NODES puts nodes at both ends "
        "of the ramp of a linear start, as the default does where they are not among its own; the "
        "word start takes the axes of the start",
    )
    start: str = word(
        "eq25",
        "start from this schedule: eq25, linear:LO,HI [r/min], a file that sensorless tune wrote, "
        "or the folder of a training run",
    )
    gains: str = word(
        "",
        "let the table also set these gains of the drive, commas between: observer, injection, "
        "l_q, amplitude, each alone or with its range as NAME:LOW:HIGH, factors on the static "
        "gain; they start static, and the reward is that of Blend-v1 with the costs below; tables "
        "only",
    )
    n_envs: int = number(
        256,
        "1",
        2,
        65536,
        "run this many environments side by side; the number is even, as they are pairs that "
        "explore opposite ways",
    )
    n_steps: int = number(
        400,
        "1",
        2,
        65536,
        "update after this many decisions of each environment; 400 of 5 ms are a whole scenario, "
        "at whose time limit the critic's value stands for what would follow",
    )
    batch_size: int = number(12800, "1", 2, 10**7, "use this many samples in a gradient step")
    n_epochs: int = number(2, "1", 1, 100, "pass over the samples this many times per update")
    gamma: float = number(
        0.9995,
        "1",
        0,
        1,
        "weigh a reward one decision later by this factor; near 1, a scenario counts as a whole",
    )
    gae_lambda: float = number(
        1.0,
        "1",
        0,
        1,
        "trade bias against variance of the advantages by this factor; below 1, what comes late "
        "counts less",
    )
    lr_nodes: float = number(
        1e-2, "1", 1e-6, 1, "let Adam, the optimiser, move a table's nodes by steps of this size"
    )
    lr_critic: float = number(
        1e-3,
        "1",
        1e-6,
        1,
        "let Adam move the critic, and the actor of an mlp, by steps of this size",
    )
    lr_end: float = number(
        0.05, "1", 0, 1, "let both steps of Adam fall along a straight line to this share"
    )
    clip_range: float = number(
        0.2, "1", 0.01, 1, "bound the probability ratio of an update to 1 plus or minus this number"
    )
    noise: float = number(
        0.1,
        "1",
        1e-3,
        1,
        "explore k_s with this standard deviation; what is drawn lasts for a rollout",
    )
    smoothness: float = number(
        2.0, "nodes", 0, 10, "let nodes explore and move together over this distance; tables only"
    )
    margin: float = number(
        MARGIN,
        "1",
        0,
        1,
        "let nodes of k_s lie this far outside 0 to 1, and start there if they are 0 or 1; where "
        "it exceeds --noise by much, exploration does not reach beyond the band of the start; "
        "tables only",
    )
    ripple_cost: float = number(
        WindowWeights.torque_ripple, "1/ms", 0, 10, "charge this for ripple in training with gains"
    )
    ripple_weight: float = number(
        1.0, "1", 0, 1e3, "weigh ripple by this factor in the objective that picks the best table"
    )
    last: bool = switch(
        False,
        "keep the table validated last, not the best: for training that asks for what the "
        "objective does not count, such as less injection",
    )
    outlier: float = number(
        0.0,
        "1",
        0,
        1e3,
        "count the advantage of a pair at most this many times the usual, so that one lost "
        "scenario does not drown what all others say; 0 counts all of it",
    )
    average: int = number(5, "1", 1, 10**6, "validate and keep a running mean of so many updates")
    warm_up: int = number(2, "1", 0, 10**6, "update the critic alone this many times first")
    decision_ms: float = number(
        1e3 * TRAINING,
        "ms",
        0.1,
        100,
        "decide this often in training: the time between two decisions",
    )
    lost_penalty: float = number(
        1000.0,
        "1",
        0,
        1e6,
        "take this reward away when lock is lost; it must exceed the running costs that it ends: "
        "151 in a scenario of 2 s at the very worst, 192 with --gains, without those of the angle",
    )
    angle_cost: float = number(
        1.0,
        "1/ms",
        0,
        10,
        "charge this for an angle error at which lock is lost; the cost begins at 20 degrees",
    )
    hard: float = number(
        0.0,
        "1",
        0,
        1,
        "take this share of the scenarios from hard-train, the finds of a search for losses: of "
        "stress-1 alone, too few are lost to learn from",
    )
    low_inertia: float = number(0.0, "1", 0, 1, "take this share of the scenarios from low-inertia")
    mismatch: float = number(0.0, "1", 0, 1, "take this share of the scenarios from mismatch")
    injection_cost: float = number(
        RewardWeights.injection, "1/ms", 0, 10, "charge this while injection is on"
    )
    speed_cost: float = number(
        RewardWeights.speed_deviation, "1/ms", 0, 10, "charge this for speed off the twin's"
    )
    eval_freq: int = number(
        500_000, "1", 1, 10**12, "validate after this many decisions, summed over all environments"
    )
    validate_size: int = number(
        1024,
        "1",
        16,
        10**6,
        "validate on this many scenarios, from seeds of neither training nor tests",
    )

    def __post_init__(self) -> None:
        """Check every setting, and those that depend on each other.

        Raises
        ------
        UserError
            Names the setting, its value and what it must be.
        """
        check(self)
        if not self.minutes and not self.steps:
            raise UserError("minutes, steps: 0 and 0: give one of them above 0")
        if self.gains and self.policy_kind != "table":
            raise UserError("gains: only a table sets them: use --policy-kind table")
        self._named_gains()
        if round(sum(self.others.values()), 9) > 1.0:
            raise UserError(
                f"hard, low_inertia, mismatch: {self.hard:g}, {self.low_inertia:g}, "
                f"{self.mismatch:g}: their sum must be at most 1"
            )
        if self.n_envs % 2:
            raise UserError(f"n_envs: {self.n_envs}: must be even, such as {self.n_envs + 1}")
        if 2 * self.machines > self.n_envs:
            raise UserError(
                f"machines: {self.machines}: must be at most half of n_envs = {self.n_envs}"
            )

    @property
    def others(self) -> dict[str, float]:
        """Share of the scenarios that other suites than ``stress-1`` give, by suite."""
        shares = {"hard-train": self.hard, "low-inertia": self.low_inertia}
        return {k: v for k, v in {**shares, "mismatch": self.mismatch}.items() if v}

    @property
    def gain_ranges(self) -> dict[str, Gain]:
        """Range of each of ``gains``, by name, in the order of every table."""
        return {name: self._named_gains()[name] for name in ranks(self._named_gains())}

    def _named_gains(self) -> dict[str, Gain]:
        out: dict[str, Gain] = {}
        for text in filter(None, (part.strip() for part in self.gains.split(","))):
            name, *bounds = text.split(":")
            if name not in DEFAULT:
                raise UserError(f"gains: {name!r} is unknown; choose from {', '.join(DEFAULT)}")
            if name in out:
                raise UserError(f"gains: {name!r} is given twice; give it once")
            try:
                low, high = map(float, bounds or (DEFAULT[name].low, DEFAULT[name].high))
            except ValueError:
                raise UserError(f"gains: {text!r}; write {name}, or {name}:LOW:HIGH") from None
            out[name] = GainGrid(name, np.zeros(1, dtype=np.float32), low, high).range
        return out

    def start_table(self, source: KsTable, motor: Motor, slew_per_s: float) -> KsTable:
        """Return the table training starts from: ``source`` on the axes of this run.

        The gains of a source are kept, others start at 0.

        Raises
        ------
        UserError
            The run would lose gains of the source: its axes, gains or ranges are other ones.
        """
        table = start_table(self.axes, self.start, source, motor, slew_per_s)
        kept, ranges = {g.gain: g for g in source.gains}, self.gain_ranges
        if any(ranges.get(x) != g.range for x, g in kept.items()) or (
            kept and table.axes != source.axes
        ):
            words = ",".join(f"{x}:{g.range.low:g}:{g.range.high:g}" for x, g in kept.items())
            raise UserError(
                f"start: {self.start!r} sets gains, which this run would lose or scale otherwise; "
                f"give --axes start --gains {words}, and more gains if you want"
            )
        zero = np.zeros(table.values.shape, dtype=np.float32)
        grids = tuple(
            kept[name] if name in kept else GainGrid(name, zero, x.low, x.high)
            for name, x in ranges.items()
        )
        return replace(table, gains=grids)

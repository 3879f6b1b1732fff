"""Environments to train in: scenarios of the suite ``stress-1`` with the role ``train``."""

from collections.abc import Sequence
from dataclasses import asdict, fields

import numpy as np

from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_settings import Sampler
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenarios.finds import hard_scenarios
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import ROLES
from sensorless.envs.several import SeveralMachines
from sensorless.envs.window_reward import WindowWeights
from sensorless.machine.motor import Motor

OF_HARD = 100
"""Added to the role for the draws that decide which scenarios are hard."""
REPEATS = 10_000
"""Indices from here on repeat the suite, so every number is moved."""


def training_scenarios(motor: Motor, seeds: Seeds) -> Scenarios:
    """Scenarios of the suite ``stress-1`` with the role ``train``."""
    return stress_1_scenarios(motor, combine(ROLES["train"], seeds))


def with_hard(share: float) -> Sampler:
    """Sampler of the same, but a ``share`` of them of the suite ``hard-train``, slightly moved."""

    def draw(motor: Motor, seeds: Seeds) -> Scenarios:
        usual, chance = training_scenarios(motor, seeds), combine(ROLES["train"] + OF_HARD, seeds)
        rows = np.flatnonzero(chance < np.uint64(share * (2**64 - 2**11)))
        if not len(rows):
            return usual
        repeats = REPEATS + (chance[rows] >> np.uint64(34)).astype(np.int64)
        hard = hard_scenarios(motor, chance[rows], repeats, 1)
        out = {f.name: getattr(usual, f.name).copy() for f in fields(usual)}
        for name, values in out.items():
            values[rows] = getattr(hard, name)
        return Scenarios(**out)

    return draw


def training_env(config: TrainConfig, design: DriveDesign, motors: Sequence[Motor]) -> SB3VecEnv:
    """Return all environments of a run, with the truth appended for the critic.

    Pairs are spread evenly over the machines; the first machines get what is left over.
    """
    share, more = divmod(config.n_envs // 2, len(motors))
    ranges = config.gain_ranges
    weights = RewardWeights(
        lost=config.lost_penalty,
        angle=config.angle_cost,
        injection=config.injection_cost,
        speed_deviation=config.speed_cost,
    )
    if ranges:
        weights = WindowWeights(**{**asdict(weights), "torque_ripple": config.ripple_cost})
    envs = [
        BlendVectorEnv(
            2 * (share + (i < more)),
            autoreset_mode="SameStep",
            motor=motor,
            design=design,
            decision_period=1e-3 * config.decision_ms,
            scenarios=with_hard(config.hard) if config.hard else training_scenarios,
            weights=weights,
            gains=tuple(ranges),
            gain_ranges=ranges,
        )
        for i, motor in enumerate(motors)
    ]
    return SB3VecEnv(envs[0] if len(envs) == 1 else SeveralMachines(envs), privileged=True)


def stream(seed: int, step: int) -> int:
    """Seed of the scenario streams of a run that starts or continues at a step.

    The stream of environment i follows from this seed plus i; hashing keeps two runs apart.
    """
    return int(combine(seed, step)[0] >> np.uint64(2))

"""Environments to train in: scenarios of ``stress-1`` with the role ``train``, and of others."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields

import numpy as np

from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_settings import Sampler
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import ROLES, sampler
from sensorless.envs.several import SeveralMachines
from sensorless.envs.window_reward import WindowWeights
from sensorless.machine.motor import Motor

OF_OTHERS = 100
"""Added to the role for the draws that decide which scenarios another suite gives."""


def training_scenarios(motor: Motor, seeds: Seeds) -> Scenarios:
    """Scenarios of the suite ``stress-1`` with the role ``train``."""
    return stress_1_scenarios(motor, combine(ROLES["train"], seeds))


def with_others(shares: Mapping[str, float]) -> Sampler:
    """Sampler of the same, but for the shares that other suites give, by their names.

    Scenarios of ``hard-train`` are slightly moved.
    """

    def draw(motor: Motor, seeds: Seeds) -> Scenarios:
        usual, chance = training_scenarios(motor, seeds), combine(ROLES["train"] + OF_OTHERS, seeds)
        out = {f.name: getattr(usual, f.name).copy() for f in fields(usual)}
        begin = 0.0
        for name, share in shares.items():
            low, high = (np.uint64(x * (2**64 - 2**11)) for x in (begin, min(begin + share, 1.0)))
            begin += share
            rows = np.flatnonzero((chance >= low) & (chance < high))
            if len(rows):
                drawn = sampler(name)(motor, chance[rows])
                for field, values in out.items():
                    values[rows] = getattr(drawn, field)
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
        GainVectorEnv(
            2 * (share + (i < more)),
            autoreset_mode="SameStep",
            motor=motor,
            design=design,
            decision_period=1e-3 * config.decision_ms,
            scenarios=with_others(config.others) if config.others else training_scenarios,
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

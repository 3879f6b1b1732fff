"""Environments to train in: scenarios of the suite ``stress-1`` with the role ``train``."""

from collections.abc import Sequence

import numpy as np

from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import ROLES
from sensorless.envs.several import SeveralMachines
from sensorless.envs.window_reward import WindowWeights
from sensorless.machine.motor import Motor


def training_scenarios(motor: Motor, seeds: Seeds) -> Scenarios:
    """Scenarios of the suite ``stress-1`` with the role ``train``."""
    return stress_1_scenarios(motor, combine(ROLES["train"], seeds))


def training_env(config: TrainConfig, design: DriveDesign, motors: Sequence[Motor]) -> SB3VecEnv:
    """Return all environments of a run, with the truth appended for the critic.

    Pairs are spread evenly over the machines; the first machines get what is left over.
    """
    share, more = divmod(config.n_envs // 2, len(motors))
    names = config.gain_names
    lost, angle = config.lost_penalty, config.angle_cost
    weights: RewardWeights | WindowWeights = RewardWeights(lost=lost, angle=angle)
    if names:
        weights = WindowWeights(lost=lost, angle=angle, torque_ripple=config.ripple_cost)
    envs = [
        BlendVectorEnv(
            2 * (share + (i < more)),
            autoreset_mode="SameStep",
            motor=motor,
            design=design,
            decision_period=1e-3 * config.decision_ms,
            scenarios=training_scenarios,
            weights=weights,
            gains=names,
        )
        for i, motor in enumerate(motors)
    ]
    return SB3VecEnv(envs[0] if len(envs) == 1 else SeveralMachines(envs), privileged=True)


def stream(seed: int, step: int) -> int:
    """Seed of the scenario streams of a run that starts or continues at a step.

    The stream of environment i follows from this seed plus i; hashing keeps two runs apart.
    """
    return int(combine(seed, step)[0] >> np.uint64(2))

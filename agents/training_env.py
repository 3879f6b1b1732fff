"""Environments to train in: stress scenarios of the role ``train``, out of step with each other."""

from collections.abc import Sequence

import numpy as np

from sensorless.agents.sb3_adapter import SB3VecEnv
from sensorless.agents.train_config import TrainConfig
from sensorless.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenario import Scenarios
from sensorless.envs.several import SeveralMachines
from sensorless.envs.stress import stress_scenarios
from sensorless.motor import Motor
from sensorless.suites import ROLES


class TrainingScenarios:
    """Stress scenarios; the first of each environment is cut short.

    Cutting puts the environments out of step with each other, so that every rollout sees starts,
    middles and ends.
    """

    def __init__(self) -> None:
        self._first = True

    def __call__(self, motor: Motor, seeds: Seeds) -> Scenarios:
        """Scenarios of these seeds."""
        s = stress_scenarios(motor, combine(ROLES["train"], seeds))
        if self._first:
            self._first = False
            share = combine(seeds, 0).astype(np.float64) * 2.0**-64
            s.duration = s.duration * (0.05 + 0.95 * share)
        return s


def training_env(config: TrainConfig, design: DriveDesign, motors: Sequence[Motor]) -> SB3VecEnv:
    """All environments of a run, with the truth appended for the critic.

    They are shared out evenly over the machines; the first ones get what is left over.
    """
    share, more = divmod(config.n_envs, len(motors))
    envs = [
        BlendVectorEnv(
            share + (i < more),
            autoreset_mode="SameStep",
            motor=motor,
            design=design,
            decision_period=1e-3 * config.decision_ms,
            scenarios=TrainingScenarios(),
            weights=RewardWeights(lost=config.lost_penalty, angle=config.angle_cost),
        )
        for i, motor in enumerate(motors)
    ]
    return SB3VecEnv(envs[0] if len(envs) == 1 else SeveralMachines(envs), privileged=True)


def stream(seed: int, step: int) -> int:
    """Seed of the scenario streams of a run that begins or goes on at a step.

    The streams of environment i follow from this plus i; hashing keeps those of two runs apart.
    """
    return int(combine(seed, step)[0] >> np.uint64(2))

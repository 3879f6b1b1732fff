"""Environments in pairs: the same scenario and sensor noise, opposite exploration.

The cost of scenarios differs far more from one to the next than a schedule can change it, so a
return alone says little about an action. Within a pair these differences cancel.

Exploration persists over a rollout (``NodeNoise``), so a rollout is one decision, and its whole
gain counts for each of its steps. Reward to go, the usual choice in PPO, would credit late steps
with the after-effects of the same noise in early ones: it has the wrong sign where an angle that
helps at once costs torque later.
"""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import RolloutBuffer

from sensorless.agents.train.sb3_adapter import SB3VecEnv


def paired_seeds(first: int, n: int) -> list[int]:
    """Seeds of n environments: 2 i and 2 i + 1 are partners and share a seed."""
    return [first + i // 2 for i in range(n)]


def opposite(z: torch.Tensor) -> torch.Tensor:
    """Noise (2 n, ...) of n pairs from the noise (n, ...) of the first of each."""
    return torch.stack((z, -z), dim=1).flatten(0, 1)


USUAL = 0.95
"""Share of the pairs whose advantages are not cut before the usual size is taken."""


class PairedRolloutBuffer(RolloutBuffer):
    """Advantage at every step of a rollout: half of its own minus half of its partner's.

    With gae_lambda = 1, a rollout's own advantage is what it earned plus the critic's value of its
    end minus that of its beginning. Once one of a pair begins a new episode, the two have nothing
    in common any more, and the advantage is 0 until `restart`, in later rollouts, too.

    Parameters
    ----------
    outlier : float
        Count an advantage at most this many times the root mean square of the others, taken with
        the largest 5 % cut; 0 counts all of it.
    """

    def __init__(self, *args: Any, outlier: float = 0.0, **kwargs: Any) -> None:
        self._outlier = outlier
        super().__init__(*args, **kwargs)
        self.join()

    def join(self) -> None:
        """Both of each pair begin the same scenario with the next step."""
        self._joined, self._parted = True, np.zeros(self.n_envs // 2, dtype=bool)

    def compute_returns_and_advantage(
        self, last_values: torch.Tensor, dones: NDArray[np.bool_]
    ) -> None:
        """Set the advantages; the returns, which the critic learns, stay each environment's own."""
        super().compute_returns_and_advantage(last_values, dones)
        gain = 0.5 * (self.advantages[0, 0::2] - self.advantages[0, 1::2])
        if self._outlier:
            square = gain**2
            most = np.sqrt(np.mean(np.minimum(square, np.quantile(square, USUAL))))
            gain = np.clip(gain, -self._outlier * most, self._outlier * most)
        begun = self.episode_starts > 0.0
        if self._joined:
            begun[0] = False
        apart = np.maximum.accumulate(begun[:, 0::2] | begun[:, 1::2], axis=0) | self._parted
        self._joined, self._parted = False, apart[-1]
        half = np.where(apart, 0.0, gain).astype(np.float32)
        self.advantages = np.stack((half, -half), axis=2).reshape(self.advantages.shape)


def restart(model: BaseAlgorithm, seed: int) -> None:
    """Begin an episode in every environment of a model on `SB3VecEnv`, partners in step."""
    env = model.env
    assert isinstance(env, SB3VecEnv)
    env.seed_each(paired_seeds(seed, model.n_envs))
    model._last_obs = env.reset()
    model._last_episode_starts = np.ones((model.n_envs,), dtype=bool)
    buffer = getattr(model, "rollout_buffer", None)
    if isinstance(buffer, PairedRolloutBuffer):
        buffer.join()

"""Environments in pairs: the same scenario and sensor noise, opposite exploration.

What scenarios cost differs far more from one to the next than anything a schedule can change, so a
return alone says little about an action. Between the two of a pair all of that cancels out.

Exploration persists over a rollout (``NodeNoise``), so a rollout is one decision, and what it gains
counts as a whole for each of its steps. Reward to go, as usual in PPO, would credit late steps with
the after-effects of the same noise in early ones: it has the wrong sign where an angle that helps
at once costs torque later.
"""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.buffers import RolloutBuffer


def paired_seeds(first: int, n: int) -> list[int]:
    """Seeds of n environments: 2 i and 2 i + 1 are partners and share one."""
    return [first + i // 2 for i in range(n)]


def opposite(z: torch.Tensor) -> torch.Tensor:
    """Noise (2 n, ...) of pairs from that of the first of each (n, ...)."""
    return torch.stack((z, -z), dim=1).flatten(0, 1)


class PairedRolloutBuffer(RolloutBuffer):
    """Advantage of a rollout less that of the partner's, halved, at every step of it.

    With gae_lambda = 1 that of a rollout is what it earned plus the critic's value of its end less
    that of its beginning. From the first step at which one of a pair begins anew, the two have
    nothing in common any more: advantage 0.
    """

    def compute_returns_and_advantage(
        self, last_values: torch.Tensor, dones: NDArray[np.bool_]
    ) -> None:
        """Set advantages; the returns, for the critic, stay each environment's own."""
        super().compute_returns_and_advantage(last_values, dones)
        first, second = self.advantages[0, 0::2], self.advantages[0, 1::2]
        begun = np.cumsum(self.episode_starts[1:], axis=0) > 0.0
        apart = np.zeros((self.buffer_size, self.n_envs // 2), dtype=bool)
        apart[1:] = begun[:, 0::2] | begun[:, 1::2]
        half = np.where(apart, 0.0, 0.5 * (first - second)).astype(np.float32)
        self.advantages = np.stack((half, -half), axis=2).reshape(self.advantages.shape)


def restart(model: Any, seed: int) -> None:
    """Begin an episode in every environment of a model, partners in step."""
    model.env.seed_each(paired_seeds(seed, model.n_envs))
    model._last_obs = model.env.reset()
    model._last_episode_starts = np.ones((model.n_envs,), dtype=bool)

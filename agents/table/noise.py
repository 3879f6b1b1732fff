"""Exploration that persists: each environment follows its own perturbed table for a while."""

import torch
from stable_baselines3.common.distributions import DiagGaussianDistribution
from torch import Tensor
from torch.distributions import Normal

from sensorless.agents.pairs import opposite
from sensorless.agents.table.kernel import NodeKernel


class NodeNoise(DiagGaussianDistribution):
    """Gaussian distribution of the action whose samples come from noise on the nodes of a table.

    a = mean + std (w . z) / |w|_C,   z ~ N(0, C) per environment, held until the next ``draw``

    with w the weights of the corners of the cell that an observation falls into and C the
    correlation between nodes. This is generalised state-dependent exploration (arXiv 2005.05719) on
    the basis functions of the table, normalised to the same standard deviation everywhere. Each
    single action is Normal(mean, std), and that is what PPO's ratio uses.
    """

    def __init__(self, kernel: NodeKernel, outputs: int = 1) -> None:
        super().__init__(action_dim=outputs)
        self._kernel = kernel
        self.z = torch.zeros(0, outputs, 0)
        """(n_envs, outputs, nodes) noise that is held."""
        self._offset = torch.zeros(0, outputs)

    def draw(self, n_envs: int) -> None:
        """Draw new noise for every pair of environments and every node, opposite within a pair."""
        pairs = (n_envs + 1) // 2
        z = self._kernel.sample(pairs * self.action_dim).reshape(pairs, self.action_dim, -1)
        self.z = opposite(z)[:n_envs]

    def at(
        self, mean: Tensor, std: Tensor, nodes: Tensor, frac: Tensor, weights: Tensor
    ) -> "NodeNoise":
        """Set the distribution at n observations from means (n, outputs), corners and weights."""
        self.distribution = Normal(mean, std.expand_as(mean))
        if len(self.z) == len(mean):
            corners = nodes[:, None].expand(-1, self.action_dim, -1)
            z = (self.z.gather(2, corners) * weights[:, None]).sum(dim=2)
            self._offset = std * z / self._kernel.spread(frac)
        else:
            self._offset = std * torch.randn_like(mean)
        return self

    def sample(self) -> Tensor:
        """Return the means plus the held noise."""
        return self.distribution.mean + self._offset

"""Actor and critic for PPO with a network as the actor: what a table is measured against."""

from collections.abc import Callable
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import Distribution, StateDependentNoiseDistribution
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import Tensor, nn

from sensorless.agents.mlp.schedule import BOUND, LAYERS, MARGIN, SCALE, MlpSchedule
from sensorless.agents.pairs import opposite
from sensorless.agents.table.module import TableModule
from sensorless.agents.table.policy import Scaled
from sensorless.core.api import SIGNAL_N
from sensorless.table.ks_table import KsTable


class SplitExtractor(nn.Module):
    """Two hidden layers for the actor, over the signals, and two for the critic, over all columns.

    The actor's features have one more column: the action of the start table.
    """

    scale: Tensor

    def __init__(self, columns: int, hidden: int, start: TableModule) -> None:
        super().__init__()
        self.latent_dim_pi = self.latent_dim_vf = hidden
        self.actor, self.critic = _hidden(SIGNAL_N, hidden), _hidden(columns, hidden)
        self._start = [
            start
        ]  # in a list, so that its nodes do not become parameters of this module
        self.register_buffer("scale", torch.tensor(SCALE), persistent=False)

    def forward(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """Features of actor and critic."""
        return self.forward_actor(features), self.forward_critic(features)

    def forward_actor(self, features: Tensor) -> Tensor:
        """(n, hidden + 1)."""
        signals = features[:, :SIGNAL_N]
        with torch.no_grad():
            start = (1.0 + 2.0 * MARGIN) * (2.0 * self._start[0](signals) - 1.0)
        return torch.cat((self.actor((signals * self.scale).clamp(-BOUND, BOUND)),
                          start[:, None]), dim=1)  # fmt: skip

    def forward_critic(self, features: Tensor) -> Tensor:
        """(n, hidden)."""
        out: Tensor = self.critic(features)
        return out


class MlpActorCritic(ActorCriticPolicy):
    """Mean action: that of the start table plus a network of the signals, zero before training.

    Exploration is SB3's gSDE on the actor's last hidden layer and persists over a rollout. Columns
    behind the signals hold the truth (``privileged``) and reach the critic only.

    Parameters
    ----------
    table : KsTable
        Schedule that the actor starts as.
    noise : float
        Approximate standard deviation of the exploration in k_s at the start.
    value_scale : float
        Size of a typical return, the unit of the critic's network.
    hidden : int
        Width of the layers.
    """

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        lr_schedule: Callable[[float], float],
        *,
        table: KsTable,
        noise: float,
        value_scale: float,
        hidden: int,
        use_sde: bool = True,
    ) -> None:
        self._table, self._scale, self._hidden = table, value_scale, hidden
        self.learn_actor = True
        # gSDE adds `hidden` tanh units of about 0.3 RMS, each with its own noise.
        log_std = float(torch.log(torch.tensor(2.0 * noise / (0.3 * hidden**0.5))))
        super().__init__(
            observation_space, action_space, lr_schedule, use_sde=use_sde, log_std_init=log_std
        )

    def _build_mlp_extractor(self) -> None:
        split = SplitExtractor(self.features_dim, self._hidden, TableModule(self._table))
        self.mlp_extractor = split  # type: ignore[assignment]

    def _build(self, lr_schedule: Callable[[float], float]) -> None:
        super()._build(lr_schedule)
        nn.init.zeros_(self.action_net.weight)  # type: ignore[arg-type]
        nn.init.zeros_(self.action_net.bias)  # type: ignore[arg-type]
        self.value_net = Scaled(self._hidden, self._scale)
        self._lr = lr_schedule(1)
        self.optimizer = torch.optim.Adam(self.parameters(), lr=self._lr, eps=1e-8)
        self.optimizer.register_step_pre_hook(self._before_step)

    def reset_noise(self, n_envs: int = 1) -> None:
        """Draw the noise of the next rollout, opposite in the two environments of a pair."""
        super().reset_noise(n_envs)
        noise = self.action_dist
        assert isinstance(noise, StateDependentNoiseDistribution)
        half = noise.exploration_matrices[: (n_envs + 1) // 2]
        noise.exploration_matrices = opposite(half)[:n_envs]

    def _actor(self) -> list[Tensor]:
        """Arrays of ``LAYERS``, weights transposed."""
        hidden = list(self.mlp_extractor.actor.parameters())  # type: ignore[union-attr]
        return [*hidden, *self.action_net.parameters()]

    def _before_step(self, *_: object) -> None:
        if not self.learn_actor:
            for p in (*self._actor(), self.log_std):
                p.grad = None

    def _get_action_dist_from_latent(self, latent_pi: Tensor) -> Distribution:
        features, start = latent_pi[:, :-1], latent_pi[:, -1:]
        mean = self.action_net(features) + start
        return self.action_dist.proba_distribution(mean, self.log_std, features)

    def steps(self) -> list[float]:
        """Learning rate of the optimiser's group at the start."""
        return [self._lr]

    def vector(self) -> Tensor:
        """Copy of all numbers of the actor."""
        return torch.cat([p.detach().reshape(-1) for p in self._actor()])

    def schedule(self, vector: Tensor) -> MlpSchedule:
        """Schedule with the numbers of ``vector``."""
        parts = vector.split([p.numel() for p in self._actor()])
        shaped = [
            x.reshape(p.shape).mT if p.ndim == 2 else x
            for x, p in zip(parts, self._actor(), strict=True)
        ]
        arrays = {k: x.numpy().copy(order="C") for k, x in zip(LAYERS, shaped, strict=True)}
        return MlpSchedule("mlp", self._table, arrays)


def _hidden(inputs: int, width: int) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, width), nn.Tanh(), nn.Linear(width, width), nn.Tanh())

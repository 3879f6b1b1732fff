"""Actor and critic for PPO: the schedule table acts, a small network that sees the truth judges."""

from collections.abc import Callable
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import Tensor, nn

from sensorless.agents.node_noise import NodeNoise
from sensorless.agents.table_module import TableModule
from sensorless.ks_table import KsTable


class TableActorCritic(ActorCriticPolicy):
    """Mean action 2 k_s - 1 from a ``TableModule``; the critic is a network over all columns.

    Columns behind the signals (the truth: privileged) reach the critic only. Nodes and critic have
    learning rates of their own, in the optimiser's two parameter groups.

    Parameters
    ----------
    table : KsTable
        Axes and start of the actor.
    lr_nodes : float
        Step of Adam on the nodes; the critic's comes with ``lr_schedule``.
    noise : float
        Standard deviation of the exploration in k_s.
    persistent : bool
        Noise on the nodes, held for a rollout (``NodeNoise``), instead of white noise.
    smoothness : float
        Share of the table's roughness that one step of the optimiser takes away.
    value_scale : float
        Size of a typical return: the critic's network works in units of it.
    hidden : int
        Width of the critic's two layers.
    """

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        lr_schedule: Callable[[float], float],
        *,
        table: KsTable,
        lr_nodes: float,
        noise: float,
        persistent: bool,
        smoothness: float,
        value_scale: float,
        hidden: int,
        use_sde: bool = False,
    ) -> None:
        self._settings = {
            "table": table, "lr_nodes": lr_nodes, "noise": noise, "persistent": persistent,
            "smoothness": smoothness, "value_scale": value_scale, "hidden": hidden,
        }
        super().__init__(observation_space, action_space, lr_schedule, net_arch={"pi": [], "vf": []})
        self.use_sde = use_sde

    def _get_constructor_parameters(self) -> dict[str, Any]:
        kept = ("observation_space", "action_space", "lr_schedule", "use_sde")
        data = super()._get_constructor_parameters()
        return {**{name: data[name] for name in kept if name in data}, **self._settings}

    def _build(self, lr_schedule: Callable[[float], float]) -> None:
        s = self._settings
        self._build_mlp_extractor()
        self.actor = TableModule(s["table"])
        self.value_net = nn.Sequential(
            nn.Linear(self.features_dim, s["hidden"]), nn.Tanh(),
            nn.Linear(s["hidden"], s["hidden"]), nn.Tanh(),
            Scaled(s["hidden"], s["value_scale"]),
        )
        self.std = torch.tensor(2.0 * s["noise"])
        self.action_dist = NodeNoise()
        self.optimizer = torch.optim.Adam(
            [
                {"params": list(self.actor.parameters()), "lr": s["lr_nodes"], "own_lr": s["lr_nodes"]},
                {"params": list(self.value_net.parameters()), "lr": lr_schedule(1)},
            ],
            eps=1e-5,
        )
        self.optimizer.register_step_post_hook(self._after_step)

    def _after_step(self, *_: object) -> None:
        self.actor.relax(self._settings["smoothness"])
        self.actor.project()

    def reset_noise(self, n_envs: int = 1) -> None:
        """Draw the noise of the next rollout."""
        if self._settings["persistent"]:
            self.action_dist.draw(n_envs, self.actor.values.numel())

    def _get_action_dist_from_latent(self, latent_pi: Tensor) -> Distribution:
        corners = self.actor.corners(latent_pi)
        mean = 2.0 * self.actor.at(*corners)[:, None] - 1.0
        return self.action_dist.at(mean, self.std, corners[0], self.actor.weights(corners[1]))


class Scaled(nn.Linear):
    """Linear layer with one output in units of ``scale``, zero at the start."""

    def __init__(self, width: int, scale: float) -> None:
        super().__init__(width, 1)
        self._scale = scale
        nn.init.zeros_(self.weight)
        nn.init.zeros_(self.bias)

    def forward(self, x: Tensor) -> Tensor:
        """Return the value (n, 1)."""
        return self._scale * super().forward(x)

"""Actor and critic for PPO: a schedule table acts, a small network that sees the truth judges."""

from collections.abc import Callable
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import Distribution
from stable_baselines3.common.policies import ActorCriticPolicy
from torch import Tensor, nn

from sensorless.agents.table.kernel import NodeKernel
from sensorless.agents.table.module import TableModule
from sensorless.agents.table.noise import NodeNoise
from sensorless.agents.table.start import MARGIN
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable


class TableActorCritic(ActorCriticPolicy):
    """Mean action 2 k_s - 1 from a ``TableModule``; the critic is a network over all columns.

    Columns behind the signals hold the truth (``privileged``) and reach the critic only. Nodes and
    critic have their own learning rates, in two parameter groups of the optimiser. The nodes'
    gradient is scaled by its usual size, and Adam's eps is 1 in that unit: nodes that matter little
    move little, instead of drifting as far as all others.

    Parameters
    ----------
    table : KsTable
        Axes and start values of the actor.
    lr_nodes : float
        Step of Adam on the nodes; ``lr_schedule`` has that of the critic.
    noise : float
        Standard deviation of the exploration in k_s.
    smoothness : float
        Distance over which nodes explore and move together [nodes], see ``NodeKernel``.
    margin : float
        How far nodes of k_s may lie outside [0, 1].
    value_scale : float
        Size of a typical return, the unit of the critic's network.
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
        smoothness: float,
        value_scale: float,
        hidden: int,
        margin: float = MARGIN,
        use_sde: bool = True,
    ) -> None:
        self._settings: dict[str, Any] = {
            "table": table,
            "lr_nodes": lr_nodes,
            "noise": noise,
            "smoothness": smoothness,
            "value_scale": value_scale,
            "hidden": hidden,
            "margin": margin,
        }
        self.learn_actor = True
        nets: dict[str, list[int]] = {"pi": [], "vf": []}
        super().__init__(observation_space, action_space, lr_schedule, net_arch=nets)
        self.use_sde = use_sde

    def _get_constructor_parameters(self) -> dict[str, Any]:
        kept = ("observation_space", "action_space", "lr_schedule", "use_sde")
        data = super()._get_constructor_parameters()
        return {**{name: data[name] for name in kept if name in data}, **self._settings}

    def _build(self, lr_schedule: Callable[[float], float]) -> None:
        s = self._settings
        self._lr_critic = lr_schedule(1)
        self._build_mlp_extractor()
        self.actor = TableModule(s["table"], s["margin"])
        self.value_net = nn.Sequential(  # type: ignore[assignment]
            nn.Linear(self.features_dim, s["hidden"]),
            nn.Tanh(),
            nn.Linear(s["hidden"], s["hidden"]),
            nn.Tanh(),
            Scaled(s["hidden"], s["value_scale"]),
        )
        self.std = torch.tensor(2.0 * s["noise"])
        self.kernel = NodeKernel(self.actor.shape, s["smoothness"])
        self._size = [0.0] * self.actor.outputs
        self.exploration = NodeNoise(self.kernel, self.actor.outputs)
        self.action_dist = self.exploration
        self.optimizer = torch.optim.Adam(
            [
                {"params": list(self.actor.parameters()), "lr": s["lr_nodes"], "eps": 1.0},
                {"params": list(self.value_net.parameters()), "lr": self._lr_critic},
            ],
            eps=1e-8,
        )
        self.optimizer.register_step_pre_hook(self._before_step)
        self.optimizer.register_step_post_hook(self._after_step)

    def _before_step(self, *_: object) -> None:
        grids = [self.actor.values] if self.actor.gains is None else [
            self.actor.values, self.actor.gains
        ]  # fmt: skip
        if self.actor.values.grad is None or not self.learn_actor:
            for grid in grids:
                grid.grad = None
            return
        output = 0
        for grid in grids:
            assert grid.grad is not None
            rows = grid.grad.reshape(-1, self.actor.values.numel())
            scaled = [self._scaled(row, output + j) for j, row in enumerate(rows)]
            grid.grad = torch.stack(scaled).reshape(grid.shape)
            output += len(rows)

    def _scaled(self, gradient: Tensor, output: int) -> Tensor:
        """Gradient of one grid, smoothed and in units of its usual size."""
        smooth = self.kernel.smooth(gradient)
        size = float(smooth.square().mean().sqrt())
        old = self._size[output]
        self._size[output] = old + (size - old) * (0.05 if old else 1.0)
        return smooth / max(self._size[output], 1e-30)

    def _after_step(self, *_: object) -> None:
        self.actor.project()

    def reset_noise(self, n_envs: int = 1) -> None:
        """Draw the noise of the next rollout."""
        self.exploration.draw(n_envs)

    def _get_action_dist_from_latent(self, latent_pi: Tensor) -> Distribution:
        nodes, frac, finite = self.actor.corners(latent_pi)
        mean = self.actor.action(nodes, frac, finite)
        return self.exploration.at(mean, self.std, nodes, frac, self.actor.weights(frac))

    def steps(self) -> list[float]:
        """Learning rates of the optimiser's groups at the start."""
        return [self._settings["lr_nodes"], self._lr_critic]

    def vector(self) -> Tensor:
        """Copy of all node values."""
        return self.actor.vector()

    def schedule(self, vector: Tensor) -> TablePolicy:
        """Return the schedule with other node values."""
        return TablePolicy("table", self.actor.table(vector))


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

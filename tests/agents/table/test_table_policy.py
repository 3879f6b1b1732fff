"""Actor, critic and exploration as PPO uses them."""

import gymnasium
import numpy as np
import pytest
import torch

from sensorless.agents.table.kernel import NodeKernel
from sensorless.agents.table.policy import TableActorCritic
from sensorless.core.api import SIGNAL_N
from sensorless.envs.privileged import N_PRIVILEGED
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import even_at_standstill

WIDTH = SIGNAL_N + N_PRIVILEGED
AXES = (Axis("speed", 0.0, 1.0, 6), Axis("torque_current", -1.5, 1.5, 4))


def policy(noise: float = 0.1, smoothness: float = 1.0) -> TableActorCritic:
    values = even_at_standstill(np.linspace(0.0, 1.0, 24, dtype=np.float32).reshape(6, 4), AXES)
    return TableActorCritic(
        gymnasium.spaces.Box(-10.0, 10.0, (WIDTH,)),
        gymnasium.spaces.Box(-1.0, 1.0, (1,)),
        lambda _: 1e-3,
        table=KsTable(AXES, values),
        lr_nodes=2e-3,
        noise=noise,
        smoothness=smoothness,
        value_scale=20.0,
        hidden=16,
    )


def observations(n: int) -> torch.Tensor:
    return torch.rand(n, WIDTH, generator=torch.Generator().manual_seed(3)) * 2.0 - 0.5


def test_actor_never_sees_the_truth() -> None:
    net = policy()
    for p in net.value_net.parameters():  # off the flat start, so that the critic tells apart
        torch.nn.init.normal_(p)
    obs = observations(200)
    other = obs.clone()
    other[:, SIGNAL_N:] = torch.rand(200, N_PRIVILEGED)
    for x in (obs, other):
        x.requires_grad_()
    mean, mean_other = (net.get_distribution(x).mode() for x in (obs, other))
    torch.testing.assert_close(mean, mean_other, rtol=0.0, atol=0.0)
    mean.sum().backward()
    assert obs.grad is not None and not obs.grad[:, SIGNAL_N:].any()
    assert not torch.equal(net.predict_values(obs), net.predict_values(other))


def test_mean_action_is_the_table() -> None:
    net = policy()
    obs = observations(100)
    action, _ = net.predict(obs.numpy(), deterministic=True)
    k_s = net.actor.table().evaluate(obs[:, :SIGNAL_N].numpy())
    np.testing.assert_array_equal(action[:, 0], 2.0 * k_s - 1.0)


@pytest.mark.parametrize("smoothness", [0.0, 1.0, 2.0])
def test_noise_has_the_stated_size_everywhere_and_persists(smoothness: float) -> None:
    net = policy(noise=0.05, smoothness=smoothness)
    n = 4000
    net.reset_noise(n)
    for row in observations(5):
        obs = row.expand(n, WIDTH)
        with torch.no_grad():
            first, again = (net(obs)[0] for _ in range(2))
            mean = net(obs, deterministic=True)[0]
        assert torch.equal(first, again), "held until the next draw"
        assert float((first - mean).std()) == pytest.approx(2.0 * 0.05, rel=0.06)
    net.reset_noise(n)
    assert not torch.equal(net(obs)[0], first)


def test_neighbours_move_together_and_within_bounds() -> None:
    net = policy()
    start = net.actor.table().values
    obs = torch.zeros(1, WIDTH)
    obs[0, 0], obs[0, 1] = 0.4, -0.5  # exactly on the node (2, 1)
    for _ in range(20):
        loss = -net.get_distribution(obs).mode().sum()
        net.optimizer.zero_grad()
        loss.backward()
        net.optimizer.step()
    moved = net.actor.table().values - start
    assert moved[2, 1] > 0.02
    assert 0.01 < moved[1, 1] < moved[2, 1] and 0.01 < moved[2, 2] < moved[2, 1]
    assert moved[5, 3] == 0.0, "far away nothing moves"


def test_nodes_rest_while_the_critic_warms_up() -> None:
    net = policy()
    before = net.actor.values.detach().clone()
    critic = net.predict_values(observations(3)).detach()
    net.learn_actor = False
    obs = observations(64)
    for _ in range(3):
        values, log_prob, _ = net.evaluate_actions(obs, torch.zeros(64, 1))
        net.optimizer.zero_grad()
        ((values - 5.0).square().mean() - log_prob.mean()).backward()
        net.optimizer.step()
    assert torch.equal(net.actor.values, before)
    assert not torch.equal(net.predict_values(observations(3)), critic)


def test_kernel_without_length_is_independent() -> None:
    nodes = torch.rand(12)
    torch.testing.assert_close(NodeKernel((3, 4), 0.0).smooth(nodes), nodes)


@pytest.mark.parametrize("size", [1e-4, 7.0])
def test_the_first_step_of_the_nodes_does_not_depend_on_the_gradients_size(size: float) -> None:
    """Gradients in units of their usual size are 1, and so is Adam's eps: half a step."""
    net = policy(smoothness=0.0)
    before = net.actor.values.detach().clone()
    net.actor.values.grad = torch.full_like(net.actor.values, size)
    net.optimizer.step()
    moved = (before - net.actor.values.detach())[1:-1]  # the ends are clipped
    assert moved.numpy() == pytest.approx(0.5 * 2e-3, rel=1e-3)

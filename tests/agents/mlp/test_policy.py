"""What the learner sees of the network: its noise, its rate and the size of its values."""

import gymnasium
import pytest
import torch
from stable_baselines3.common.distributions import StateDependentNoiseDistribution

from sensorless.agents.mlp.policy import MlpActorCritic
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.core.api import SIGNAL_N
from sensorless.envs.privileged import N_PRIVILEGED

WIDTH = SIGNAL_N + N_PRIVILEGED


def policy(noise: float = 0.1, value_scale: float = 1.0, hidden: int = 16) -> MlpActorCritic:
    torch.manual_seed(0)
    return MlpActorCritic(
        gymnasium.spaces.Box(-10.0, 10.0, (WIDTH,)), gymnasium.spaces.Box(-1.0, 1.0, (1,)),
        lambda left: 1e-3 * left, table=linear_table(*EQ25_BAND), noise=noise,
        value_scale=value_scale, hidden=hidden,
    )  # fmt: skip


def observations(n: int, most: float = 1.0) -> torch.Tensor:
    drawn = torch.rand(n, WIDTH, generator=torch.Generator().manual_seed(3))
    return most * (2.0 * drawn - 1.0)


def matrices(net: MlpActorCritic, n: int) -> torch.Tensor:
    net.reset_noise(n)
    noise = net.action_dist
    assert isinstance(noise, StateDependentNoiseDistribution)
    return noise.exploration_matrices


def variance(net: MlpActorCritic, obs: torch.Tensor) -> torch.Tensor:
    normal = net.get_distribution(obs).distribution
    assert isinstance(normal, torch.distributions.Normal)
    return normal.variance.detach()


def test_partners_explore_in_opposite_directions() -> None:
    found = matrices(policy(), 4)
    assert torch.equal(found[0::2], -found[1::2]) and not torch.equal(found[0], found[2])
    assert matrices(policy(), 1).shape[0] == 1
    odd = matrices(policy(), 5)
    assert odd.shape[0] == 5 and not torch.equal(odd[4].abs(), odd[2].abs())


@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_the_noise_has_about_the_size_that_is_asked_for(noise: float) -> None:
    """In k_s, half of the action: within a third, over signals of all sizes up to one."""
    net = policy(noise, hidden=64)
    spread = variance(net, observations(2000)).mean().sqrt()
    assert 0.5 * float(spread) == pytest.approx(noise, rel=1.0 / 3.0)


def test_the_noise_is_that_of_the_hidden_layer_alone() -> None:
    """Its variance is the sum of feature^2 exp(2 log_std): the start's action adds none."""
    net, obs = policy(), observations(50)
    features = net.mlp_extractor.forward_actor(obs).detach()[:, :16]
    wanted = features.square() @ net.log_std.detach().exp().square()
    torch.testing.assert_close(variance(net, obs), wanted, rtol=1e-4, atol=1e-6)


def test_the_actor_learns_at_the_rate_of_the_start() -> None:
    net = policy()
    assert net.steps() == [1e-3] and net.learn_actor
    assert [group["lr"] for group in net.optimizer.param_groups] == [1e-3]


def test_the_value_is_in_units_of_a_typical_return() -> None:
    obs = observations(50)
    found = []
    for scale in (1.0, 20.0):
        net = policy(value_scale=scale)
        torch.nn.init.normal_(net.value_net.weight)
        found.append(net.predict_values(obs).detach())
    assert found[0].abs().max() > 0.1
    torch.testing.assert_close(found[1], 20.0 * found[0])


def test_the_network_sees_signals_no_larger_than_the_schedule_does() -> None:
    """Torch and numpy bound them alike, far outside of what is usual."""
    net, obs = policy(), observations(300, 60.0)
    torch.nn.init.normal_(net.action_net.weight, std=0.3)  # type: ignore[arg-type]
    action, _ = net.predict(obs.numpy(), deterministic=True)
    k_s = net.schedule(net.vector()).act(obs[:, :SIGNAL_N].numpy())
    assert k_s == pytest.approx(0.5 + 0.5 * action[:, 0], abs=1e-6)


def test_the_network_adds_nothing_before_it_has_learned() -> None:
    net = policy()
    assert [bool(p.any()) for p in net.action_net.parameters()] == [False, False]

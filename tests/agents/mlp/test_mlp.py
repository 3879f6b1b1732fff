"""The network as a policy: in torch while it learns, in numpy from its file."""

from pathlib import Path

import gymnasium
import numpy as np
import pytest
import torch

from sensorless.agents.loading import load_run
from sensorless.agents.mlp.policy import MlpActorCritic
from sensorless.agents.mlp.schedule import MARGIN, MlpSchedule
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.core.api import SIGNAL_N
from sensorless.envs.privileged import N_PRIVILEGED
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

WIDTH = SIGNAL_N + N_PRIVILEGED
EQ25 = linear_table(*EQ25_BAND)


def policy() -> MlpActorCritic:
    torch.manual_seed(0)
    return MlpActorCritic(
        gymnasium.spaces.Box(-10.0, 10.0, (WIDTH,)),
        gymnasium.spaces.Box(-1.0, 1.0, (1,)),
        lambda _: 1e-3,
        table=EQ25,
        noise=0.1,
        value_scale=20.0,
        hidden=16,
    )


def moved() -> MlpActorCritic:
    """Off its start, so that the network counts."""
    net = policy()
    torch.nn.init.normal_(net.action_net.weight, std=0.3)  # type: ignore[arg-type]
    return net


def observations(n: int) -> torch.Tensor:
    obs = torch.rand(n, WIDTH, generator=torch.Generator().manual_seed(3)) * 2.0 - 1.0
    obs[:, 0] = obs[:, 0].abs() * 0.6
    return obs


def test_before_training_it_is_its_start() -> None:
    net, obs = policy(), observations(500)
    k_s = net.schedule(net.vector()).act(obs[:, :SIGNAL_N].numpy())
    start = EQ25.evaluate(obs[:, :SIGNAL_N].numpy())
    np.testing.assert_allclose(k_s, start, atol=MARGIN + 1e-6)
    np.testing.assert_array_equal(k_s[start == 0.0], 0.0)
    assert 0.0 < start.mean() < 1.0


def test_numpy_decides_as_torch_does() -> None:
    net, obs = moved(), observations(500)
    action, _ = net.predict(obs.numpy(), deterministic=True)
    k_s = net.schedule(net.vector()).act(obs[:, :SIGNAL_N].numpy())
    np.testing.assert_allclose(k_s, 0.5 + 0.5 * action[:, 0], atol=1e-6)
    start = EQ25.evaluate(obs[:, :SIGNAL_N].numpy())
    assert np.abs(k_s - start).max() > 0.1


def test_actor_never_sees_the_truth() -> None:
    net, obs = moved(), observations(100)
    other = obs.clone()
    other[:, SIGNAL_N:] = torch.rand(100, N_PRIVILEGED)
    torch.nn.init.normal_(net.value_net.weight)
    assert torch.equal(*(net.get_distribution(x).mode() for x in (obs, other)))
    assert not torch.equal(net.predict_values(obs), net.predict_values(other))


def test_actor_rests_while_the_critic_warms_up() -> None:
    net, obs = moved(), observations(64)
    before, log_std = net.vector(), net.log_std.detach().clone()
    critic = net.predict_values(obs).detach()
    for learn in (False, True):
        net.learn_actor = learn
        values, log_prob, _ = net.evaluate_actions(obs, torch.zeros(64, 1))
        net.optimizer.zero_grad()
        ((values - 5.0).square().mean() - log_prob.mean()).backward()
        net.optimizer.step()
        assert torch.equal(net.vector(), before) != learn
        assert torch.equal(net.log_std, log_std) != learn
        assert not torch.equal(net.predict_values(obs), critic)


def test_a_row_does_not_depend_on_the_others() -> None:
    net = moved()
    schedule, obs = net.schedule(net.vector()), observations(100)[:, :SIGNAL_N].numpy()
    whole = schedule.act(obs)
    parts = np.concatenate([schedule.act(obs[i : i + 7]) for i in range(0, 100, 7)])
    np.testing.assert_array_equal(whole, parts)
    obs[3, 5] = np.nan
    assert schedule.act(obs)[3] == 1.0


def test_the_file_gives_the_same_decisions(tmp_path: Path) -> None:
    net, motor = moved(), Motor.load("paper")
    schedule, obs = net.schedule(net.vector()), observations(50)[:, :SIGNAL_N].numpy()
    schedule.save(tmp_path / "mlp.npz", {"motor_digest": motor.digest, "motor": motor.name})
    loaded = load_run(tmp_path, motor)
    np.testing.assert_array_equal(loaded.act(obs), schedule.act(obs))
    assert loaded.name == tmp_path.name
    with pytest.raises(UserError, match="digest"):
        load_run(tmp_path, Motor.load("ipmsm_2200w"))


@pytest.mark.parametrize("damage", ["cut", "shape", "nan", "pickle"])
def test_a_damaged_file_is_refused(tmp_path: Path, damage: str) -> None:
    net = policy()
    schedule, path = net.schedule(net.vector()), tmp_path / "mlp.npz"
    if damage == "shape":
        schedule.layers["w1"] = schedule.layers["w1"][:, :-1]
    if damage == "nan":
        schedule.layers["b0"][2] = np.nan
    schedule.save(path, {})
    if damage == "cut":
        path.write_bytes(path.read_bytes()[:-200])
    if damage == "pickle":
        with np.load(path) as data:
            arrays = {k: data[k] for k in data}
        arrays["w0"] = np.array([object()], dtype=object)
        np.savez(path, **arrays)
    with pytest.raises(UserError, match=r"mlp\.npz.*train anew"):
        MlpSchedule.load(path, "x")

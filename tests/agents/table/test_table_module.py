"""The table in torch is the table in C."""

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from sensorless.agents.table.module import TableModule
from sensorless.agents.table.start import MARGIN
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from sensorless.table.standstill import even_at_standstill

AXES = (
    Axis("speed", 0.0, 1.0, 16),
    Axis("torque_current", -1.5, 1.5, 5),
    Axis("disagreement", -1.0, 1.0, 4),
    Axis("acceleration", -3.0, 7.0, 3),
)
RNG = np.random.default_rng(5)


def random_table(n_axes: int) -> KsTable:
    """Random nodes, many of them at the bounds."""
    axes = AXES[:n_axes]
    nodes = RNG.uniform(-0.5, 1.5, [a.n for a in axes]).clip(0.0, 1.0)
    return KsTable(axes, nodes.astype(np.float32), fallback=0.75)


def observations(table: KsTable, n: int) -> NDArray[np.float32]:
    """Inside, outside, on the nodes, just beside them, huge, minus zero and not finite."""
    obs = RNG.normal(0.0, 2.0, (n, SIGNAL_N)).astype(np.float32)
    for axis in table.axes:
        column = obs[:, SIGNAL_NAMES.index(axis.signal)]
        kind = RNG.integers(0, 8, n)
        on_node = RNG.choice(axis.nodes, n)
        column[:] = np.where(kind < 2, RNG.uniform(axis.lo, axis.hi, n), column)
        column[:] = np.where(kind == 2, on_node, column)
        beside = np.nextafter(on_node, RNG.choice([-np.inf, np.inf], n).astype(np.float32))
        column[:] = np.where(kind == 3, beside, column)
        odd = RNG.choice([0.0, -0.0, 3e38, -3e38, np.nan, np.inf, -np.inf, 1e-42], n)
        column[:] = np.where((kind == 4) & (RNG.uniform(size=n) < 0.3), odd, column)
    return obs


@pytest.mark.parametrize("n_axes", [1, 2, 3, 4])
def test_torch_and_c_agree_to_the_bit(n_axes: int) -> None:
    table = random_table(n_axes)
    obs = observations(table, 20_000)
    with torch.no_grad():
        ours = TableModule(table)(torch.as_tensor(obs)).numpy()
    np.testing.assert_array_equal(ours.view(np.uint32), table.evaluate(obs).view(np.uint32))
    assert (ours == np.float32(0.75)).sum() > 100, "the fallback was among the cases"


def test_gradient_reaches_the_corners_with_their_weights() -> None:
    table = random_table(3)
    module = TableModule(table)
    obs = torch.as_tensor(RNG.uniform(0.1, 0.9, (1, SIGNAL_N)).astype(np.float32))
    module(obs).sum().backward()
    nodes, frac, _ = module.corners(obs)
    gradient = module.values.grad
    assert gradient is not None
    wanted = torch.zeros_like(gradient).scatter_add(0, nodes[0], module.weights(frac)[0])
    torch.testing.assert_close(gradient, wanted)
    torch.testing.assert_close(gradient.sum(), torch.tensor(1.0))


def test_projection_keeps_nodes_and_gradient_usable() -> None:
    module = TableModule(random_table(2))
    for sign in (-1.0, 1.0):
        with torch.no_grad():
            module.values.add_(sign * 5.0)
        module.project()
        assert float(module.values.detach().abs().max()) <= 1.0 + MARGIN
        assert (module.table().values == max(sign, 0.0)).all()
        module.zero_grad()
        module(torch.zeros(1, SIGNAL_N)).sum().backward()
        gradient = module.values.grad
        assert gradient is not None and gradient.sum() > 0.9, "no dead gradient at the bounds"


def test_projection_makes_nodes_even_at_standstill() -> None:
    axes = (*AXES[:2], Axis("disagreement", -1.0, 1.0, 3))
    nodes = RNG.random([a.n for a in axes], dtype=np.float32)
    module = TableModule(KsTable(axes, nodes, gains=(GainGrid("observer", nodes),)))
    module.project()
    made = module.table()
    for grid in (made.values, made.gains[0].values):
        np.testing.assert_array_equal(grid, even_at_standstill(nodes, axes))
    assert (made.values[0] != nodes[0]).any()


def test_a_little_jitter_does_not_turn_the_injection_on() -> None:
    table = KsTable(AXES[:1], np.repeat([1.0, 0.0], 8).astype(np.float32))
    module = TableModule(table)
    with torch.no_grad():
        module.values.add_(torch.as_tensor(RNG.uniform(-0.04, 0.04, 16).astype(np.float32)))
    assert module.table().digest == table.digest


def test_round_trip_keeps_every_field() -> None:
    table = random_table(3)
    assert TableModule(table).table().digest == table.digest

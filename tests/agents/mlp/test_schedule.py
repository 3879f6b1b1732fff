"""The schedule of a network, against numbers worked out by hand."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.agents.mlp.schedule import LAYERS, MlpSchedule
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.table.ks_table import Axis, KsTable


def schedule(start: float, signal: str = "speed", weight: float = 0.0, out: float = 1.0,
             bias: float = 0.0) -> MlpSchedule:  # fmt: skip
    """k_s from a constant ``start`` and out tanh(tanh(weight y)) + bias of one signal y."""
    shapes = ((SIGNAL_N, 2), (2,), (2, 2), (2,), (2, 1), (1,))
    layers = {k: np.zeros(shape, np.float32) for k, shape in zip(LAYERS, shapes, strict=True)}
    layers["w0"][SIGNAL_NAMES.index(signal), 1] = weight
    layers["w1"][1, 0] = 1.0
    layers["w2"][0, 0], layers["b2"][0] = out, bias
    table = KsTable((Axis("speed", 0.0, 1.0, 2),), np.full(2, start, np.float32))
    return MlpSchedule("by hand", table, layers)


def observation(signal: str, value: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    obs = np.zeros((1, SIGNAL_N), np.float32)
    obs[0, SIGNAL_NAMES.index(signal)] = value
    return obs


@pytest.mark.parametrize(
    ("signal", "value", "seen"),
    [
        ("speed", 0.8, 0.8),
        ("speed", 2.9, 2.9),
        ("speed", 50.0, 3.0),
        ("torque_current", -50.0, -3.0),
        ("acceleration", 20.0, 2.0),
        ("acceleration", -80.0, -3.0),
    ],
)
def test_signals_are_bounded_and_the_acceleration_counts_a_tenth(
    signal: str, value: float, seen: float
) -> None:
    k_s = schedule(0.5, signal, 0.1).act(observation(signal, value))
    assert k_s[0] == pytest.approx(0.5 + 0.5 * np.tanh(np.tanh(0.1 * seen)), abs=1e-6)


@pytest.mark.parametrize(
    ("start", "bias", "k_s"),
    [(1.0, -0.03, 1.0), (1.0, -0.06, 0.99), (0.0, 0.03, 0.0), (0.0, 0.06, 0.01), (0.5, 0.4, 0.7)],
)
def test_an_end_of_the_start_holds_until_the_network_means_it(
    start: float, bias: float, k_s: float
) -> None:
    """1/2 + 1/2 (1.04 (2 start - 1) + bias), from 0 to 1."""
    found = schedule(start, bias=bias).act(np.zeros((3, SIGNAL_N), np.float32))
    assert found == pytest.approx(np.full(3, k_s), abs=1e-6)
    if k_s in (0.0, 1.0):
        assert (found == k_s).all()


def test_a_file_that_is_missing_or_lacks_an_array_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"none\.npz: .*No such file.*train anew"):
        MlpSchedule.load(tmp_path / "none.npz", "x")
    path = tmp_path / "mlp.npz"
    schedule(0.5).save(path, {})
    with np.load(path) as data:
        np.savez(path, **{k: data[k] for k in data if k != "w1"})
    with pytest.raises(UserError, match=r"mlp\.npz: .*w1.*train anew"):
        MlpSchedule.load(path, "x")

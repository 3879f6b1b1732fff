"""Seven numbers and what each of them moves."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.logistic import RULE, logistic_table
from sensorless.policy import Signals

BASE = {**RULE.defaults(), "speed": 0.3, "width": 0.2}


def test_one_half_at_its_centre_and_certain_far_from_it(signals: Callable[..., Signals]) -> None:
    k_s = logistic_table(BASE).evaluate(signals(speed=[0.0, 0.3, 0.7, 1.5]))
    assert k_s == pytest.approx([1.0, 0.5, 0.0, 0.0], abs=1e-3)
    assert k_s[0] == 1.0 and k_s[-1] == 0.0


def test_between_its_nodes_it_is_off_by_the_rest_of_a_line(signals: Callable[..., Signals]) -> None:
    """h^2 / 8 max |f''|, of nodes 0.05 of rated speed apart: max |f''| = 1.04 20^2 sqrt(3)/18."""
    s = np.linspace(0.0, 0.9, 361)
    exact = np.clip(1.04 / (1.0 + np.exp(-20.0 * (0.3 - s))) - 0.02, 0.0, 1.0)
    most = 0.05**2 / 8.0 * 1.04 * 20.0**2 * math.sqrt(3.0) / 18.0
    off = np.abs(logistic_table(BASE).evaluate(signals(speed=s)) - exact)
    assert 0.9 * most < off.max() < 1.01 * most


@pytest.mark.parametrize(
    ("name", "signal", "there", "elsewhere"),
    [
        ("motoring", "torque_current", 1.0, -1.0),
        ("regenerating", "torque_current", -1.0, 1.0),
        ("lead", "disagreement", 0.75, -0.75),
        ("lag", "disagreement", -0.75, 0.75),
    ],
)
def test_each_shift_acts_on_its_side_alone(
    name: str, signal: str, there: float, elsewhere: float, signals: Callable[..., Signals]
) -> None:
    obs = signals(speed=0.35, **{signal: [there, elsewhere]})
    before = logistic_table(BASE).evaluate(obs)
    after = logistic_table({**BASE, name: 0.3}).evaluate(obs)
    assert after[0] > before[0] + 0.1
    assert after[1] == before[1]


def test_spread_widens_under_load(signals: Callable[..., Signals]) -> None:
    table = logistic_table({**BASE, "spread": 1.0})
    k_s = table.evaluate(signals(speed=0.4, torque_current=[0.0, 1.0]))
    assert k_s[0] < k_s[1] < 0.5


def test_every_corner_of_the_search_is_a_table() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        ends = rng.integers(0, 2, len(RULE.parameters))
        values = {p.name: p.search[e] for p, e in zip(RULE.parameters, ends, strict=True)}
        assert logistic_table(values).check() == 0

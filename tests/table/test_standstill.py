"""Schedules know no direction of motion at standstill, where it is noise."""

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.envs.signals import SIGNALS
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import SIGNED, even_at_standstill, turned_round

AXES = (
    Axis("torque_current", -1.5, 1.5, 5),
    Axis("speed", 0.0, 1.0, 6),
    Axis("disagreement", -1.0, 1.0, 4),
    Axis("voltage", 0.0, 1.0, 2),
)


def test_signed_signals_are_those_of_the_observation() -> None:
    assert {s.name for s in SIGNALS if s.low < 0.0} == set(SIGNED)


def test_a_turn_at_standstill_changes_nothing() -> None:
    rng = np.random.default_rng(1)
    values = rng.random([a.n for a in AXES], dtype=np.float32)
    table = KsTable(AXES, even_at_standstill(values, AXES))
    here = rng.uniform(-2.0, 2.0, (500, SIGNAL_N)).astype(np.float32)
    here[:, SIGNAL_NAMES.index("speed")] = 0.0
    there = here.copy()
    there[:, [SIGNAL_NAMES.index(name) for name in SIGNED]] *= -1.0
    np.testing.assert_allclose(table.evaluate(here), table.evaluate(there), atol=1e-6)
    np.testing.assert_array_equal(table.values[:, 1:], values[:, 1:])
    assert table.values[:, 0].mean() == pytest.approx(values[:, 0].mean())
    assert np.abs(table.values[:, 0] - values[:, 0]).max() > 0.1


@pytest.mark.parametrize(
    "axes",
    [AXES[:1], (AXES[1], Axis("acceleration", -3.0, 7.0, 3)), (AXES[1], AXES[3])],
    ids=["no speed", "a signed axis that is not symmetric", "nothing signed"],
)
def test_tables_that_it_leaves_alone(axes: tuple[Axis, ...]) -> None:
    assert turned_round(axes).tolist() == list(range(int(np.prod([a.n for a in axes]))))

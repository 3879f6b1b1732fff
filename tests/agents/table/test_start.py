"""What training starts from: exact copies, sampled copies, and words that are refused."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.agents.table.start import AXES as DEFAULT
from sensorless.agents.table.start import start_table
from sensorless.baselines.linear import linear_table
from sensorless.baselines.logistic import RULE as LOGISTIC
from sensorless.baselines.logistic import logistic_table
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.policies.tuned import Tuned

MOTOR = Motor.load("paper")
AXES = "speed:16,torque_current:-1.5:1.5:5"


def observations(n: int) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    rng = np.random.default_rng(0)
    obs = rng.uniform(-1.5, 1.5, (n, SIGNAL_N)).astype(np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = rng.uniform(0.0, 1.5, n)
    return obs


@pytest.mark.parametrize(("low", "high"), [(0.163004, 0.371973), (0.0, 0.11), (0.2, 0.8 / 3.0)])
def test_a_tuned_ramp_lies_on_placed_nodes(tmp_path: Path, low: float, high: float) -> None:
    Tuned("linear", {"lo": low, "hi": high}, {}).save(tmp_path / "linear.json")
    table = start_table(
        AXES,
        str(tmp_path / "linear.json"),
        table_named(str(tmp_path / "linear.json"), MOTOR),
        MOTOR,
        50.0,
    )
    assert table.axes[0].lo >= 0.0 and table.axes[0].hi >= 1.0 - 1e-6
    obs = observations(2000)
    want = linear_table(low, high).evaluate(obs)
    # A rounding of an end of the band, on the slope of the ramp.
    np.testing.assert_allclose(table.evaluate(obs), want, atol=2e-6 / (high - low))
    assert 0.0 < want.mean() < 1.0
    assert not table.evaluate(obs)[obs[:, 0] > high + 1e-6].any(), "injection stays off"


@pytest.mark.parametrize("name", ["paper", "brusa_hsm1", "formula_wheel"])
def test_without_axes_eq25_is_copied_on_any_machine(name: str) -> None:
    motor = Motor.load(name)
    source = table_named("eq25", motor)
    table = start_table(DEFAULT, "eq25", source, motor, 50.0)
    assert (table.axes[0].hi == 1.0) == (name == "paper") and table.axes[0].n == 16
    obs = observations(2000)
    np.testing.assert_allclose(table.evaluate(obs), source.evaluate(obs), atol=5e-5)


def test_the_axes_of_the_start_copy_it_bit_by_bit() -> None:
    table = start_table(
        "start",
        "logistic:400,300,0.1,0.2,0.1,0,0.5",
        table_named("logistic:400,300,0.1,0.2,0.1,0,0.5", MOTOR),
        MOTOR,
        40.0,
    )
    values = {"speed": 400.0, "width": 300.0}
    values = {name: x / MOTOR.n_rated_rpm for name, x in values.items()}
    rest = {"motoring": 0.1, "regenerating": 0.2, "lead": 0.1, "lag": 0.0, "spread": 0.5}
    source = logistic_table({**LOGISTIC.defaults(), **values, **rest})
    np.testing.assert_array_equal(table.evaluate(observations(500)),
                                  source.evaluate(observations(500)))  # fmt: skip
    assert table.slew_per_s == 40.0


def test_another_grid_samples_the_start_at_its_nodes() -> None:
    axes = "torque_current:-1.5:1.5:4,speed:0:1.2:25,disagreement:-1.5:1.5:3"
    table = start_table(axes, "logistic", table_named("logistic", MOTOR), MOTOR, 50.0)
    obs = np.zeros((25, SIGNAL_N), dtype=np.float32)
    obs[:, 0], obs[:, 1] = table.axes[1].nodes, -0.5
    want = logistic_table(LOGISTIC.defaults()).evaluate(obs)
    np.testing.assert_allclose(table.values[1, :, 1], want, atol=1e-5)


@pytest.mark.parametrize(
    ("axes", "start", "words"),
    [
        ("speed:0:1:16", "linear:310,400", "not a node"),
        ("speed:0:1:16", "logistic", "lack torque_current"),
        ("torque_current:-1:1:3", "eq25", "lack speed"),
        ("speed:16,torque_current:-1:1:3,disagreement:-1:1:3", "logistic", "linear start"),
        ("speed", "eq25", "NODES"),
        ("speed:0:1:two", "eq25", "NODES"),
        ("speed:0:1:16", "hysteresis", "no table"),
        ("speed:0:1:16", "nobody", "is not a rule"),
    ],
)
def test_bad_words_are_refused(axes: str, start: str, words: str) -> None:
    with pytest.raises(UserError, match=words) as caught:
        start_table(axes, start, table_named(start, MOTOR), MOTOR, 50.0)
    assert "; " in str(caught.value), "says what to do"

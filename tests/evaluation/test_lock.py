"""Which alarm belongs to which verdict, on drives that only pretend."""

import numpy as np
import pytest

from sensorless.core.api import SIM, lib
from sensorless.evaluation.lock import EARLY, LockWatch, lock_summary
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
STEP = 1e-3
END = 1.0
LIMIT = 1.0


def seen(
    alarms: list[tuple[float, float]], verdict: float = np.inf, over: tuple[float, float] = (2, 2)
) -> dict[str, float]:
    """Scores of one drive with alarms from .. to [s], and an error beyond the limit in ``over``."""
    sims = np.zeros(1, dtype=SIM)
    sims["k_end"] = round(END / MOTOR.T_s)
    sims["err_limit"] = LIMIT
    sims["drive"]["x"]["start"]["phase"] = lib.START_DONE
    watch = LockWatch(MOTOR, 1)
    for j in range(1, round(END / STEP) + 1):
        t = j * STEP
        lock = sims["drive"]["x"]["lock"]
        lock["alarms"] = sum(begin <= t for begin, _ in alarms)
        lock["alarm"] = any(begin <= t < end for begin, end in alarms)
        sims["sums"]["err_max"] = 2.0 * LIMIT * (over[0] <= t < over[1])
        sims["lost"] = lib.LOST_ANGLE * (t >= verdict)
        sims["k_lost"] = round(verdict / MOTOR.T_s) if t >= verdict else 0
        sims["drive"]["y"]["theta_e"] = LIMIT * 1.5 * (t < verdict + 0.2)
        watch.look(sims)
    return {name: float(x[0]) for name, x in watch.scores(sims).items()}


@pytest.mark.parametrize(
    ("alarm", "found"),
    [((0.48, 0.6), -0.02), ((0.52, 0.6), 0.02), ((0.2, 0.6), -0.3), ((0.45, 0.47), -0.05)],
)
def test_an_alarm_belongs_to_the_verdict(alarm: tuple[float, float], found: float) -> None:
    """Shortly before it or after it, or on at it however long."""
    x = seen([alarm], verdict=0.5)
    assert x["alarm_s"] == pytest.approx(found, abs=1.5 * STEP)
    assert x["false_alarms"] == 0
    assert x["back_s"] == pytest.approx(0.2 - found, abs=3.0 * STEP)
    assert x["watched_s"] == pytest.approx(0.5)


def test_an_alarm_that_ended_long_before_is_early() -> None:
    x = seen([(0.2, 0.25)], verdict=0.5)
    assert (x["alarm_s"], x["false_alarms"], x["near_losses"]) == (np.inf, 1, 0)


@pytest.mark.parametrize(
    ("over", "near"), [((0.15, 0.16), 1), ((0.25, 0.26), 1), ((0.4, 0.41), 0), ((0.05, 0.06), 0)]
)
def test_a_near_loss_has_an_error_beyond_the_limit(over: tuple[float, float], near: int) -> None:
    assert EARLY == 0.1
    x = seen([(0.2, 0.25)], over=over)
    assert (x["false_alarms"], x["near_losses"]) == (1, near)
    assert np.isnan(x["alarm_s"])


def test_alarms_of_scenarios_lost_later_are_counted_apart() -> None:
    rows = [seen([(0.2, 0.25)]), seen([(0.2, 0.25)], verdict=0.5), seen([])]
    lock = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    lost = np.array([0, lib.LOST_ANGLE, 0], dtype=np.int32)
    found = lock_summary(lock, lost, np.array([END, 0.5, END]))
    assert found["lock_counts"]["false_alarms"] == 1
    assert found["lock_counts"]["early_alarms"] == 1
    assert found["false_alarms_per_hour"] == pytest.approx(3600.0 / (2.0 * END))
    assert found["detected_rate"] == 0.0

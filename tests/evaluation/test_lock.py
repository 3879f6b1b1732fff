"""Which alarm belongs to which verdict, on drives that only pretend."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIM, lib
from sensorless.evaluation.lock import EARLY, LOCK, LockWatch, in_control, lock_summary
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")
STEP = 1e-3
END = 1.0
LIMIT = 1.0


def seen(
    alarms: list[tuple[float, float]],
    verdict: float = np.inf,
    over: tuple[float, float] = (2, 2),
    stays: float = np.inf,
) -> dict[str, float]:
    """Scores of one drive with alarms from .. to [s], and an error beyond the limit in ``over``.

    It is at its angle 0.2 s after the verdict, for ``stays`` [s].
    """
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
        back = verdict + 0.2 <= t < verdict + 0.2 + stays
        sims["drive"]["y"]["theta_e"] = 0.0 if back else LIMIT * 1.5
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


@pytest.mark.parametrize(("stays", "back"), [(0.5 * STEP, False), (0.015, False), (0.025, True)])
def test_a_drive_is_back_if_it_stays_for_20_ms(stays: float, back: bool) -> None:
    assert np.isfinite(seen([(0.5, 0.6)], verdict=0.5, stays=stays)["back_s"]) == back


@pytest.mark.parametrize(("share", "at_its_angle"), [(0.99, True), (1.01, False), (-1.01, False)])
def test_an_estimate_of_a_period_before_is_compared_with_the_angle_of_then(
    share: float, at_its_angle: bool
) -> None:
    """At rated speed the shaft has turned by 3.6 degrees since."""
    sims = np.zeros(1, dtype=SIM)
    sims["err_limit"], sims["plant"]["n_p"], sims["control"]["T_s"] = LIMIT, MOTOR.n_p, MOTOR.T_s
    sims["drive"]["x"]["start"]["phase"] = lib.START_DONE
    for who in (sims["drive"], sims["twin"]):
        who["y"]["omega_m"] = MOTOR.omega_m_rated
    turn = MOTOR.omega_rated * MOTOR.T_s
    assert np.rad2deg(turn) == pytest.approx(3.6)
    sims["drive"]["y"]["theta_e"] = turn + share * LIMIT
    assert in_control(sims, 1e-3)[0] == at_its_angle


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


def summed_up(lost: Sequence[int], **scores: Sequence[float]) -> dict[str, Any]:
    """Of drives with these bits and scores, the others being 0."""
    lock = {name: np.array(scores.get(name, [0.0] * len(lost)), dtype=float) for name in LOCK}
    return lock_summary(lock, np.array(lost, dtype=np.int32), np.full(len(lost), END))


def test_an_alarm_within_50_ms_of_the_verdict_is_in_time() -> None:
    found = summed_up([lib.LOST_ANGLE] * 3, alarm_s=[-0.06, 0.045, 0.055], watched_s=[END] * 3)
    assert found["lock_counts"]["watched"] == 3
    assert found["lock_counts"]["detected"] == 2


def test_the_time_to_the_alarm_is_the_median() -> None:
    found = summed_up([lib.LOST_ANGLE] * 3, alarm_s=[0.0, 0.01, 0.05], watched_s=[END] * 3)
    assert found["detect_ms"] == pytest.approx(10.0), "the mean is 20 ms"


def test_a_drive_has_300_ms_from_the_alarm_to_come_back() -> None:
    found = summed_up([lib.LOST_ANGLE] * 2, watched_s=[END] * 2, back_s=[0.29, 0.31])
    assert found["lock_counts"]["could_recover"] == 2
    assert found["lock_counts"]["recovered"] == 1


def test_without_time_to_come_back_and_stay_recovery_is_not_judged() -> None:
    """300 ms from an alarm 10 ms after the verdict, and 20 ms: 330 ms are needed."""
    scores = {"alarm_s": [0.01] * 2, "watched_s": [0.32, 0.34], "back_s": [np.inf, 0.1]}
    found = summed_up([lib.LOST_ANGLE] * 2, **scores)
    assert found["lock_counts"]["could_recover"] == 1
    assert found["recovered_rate"] == 1.0


def test_alarms_of_scenarios_that_are_not_feasible_do_not_count() -> None:
    lost = [lib.LOST_ANGLE, lib.LOST_ANGLE | lib.LOST_TWIN]
    counts = summed_up(lost, alarm_s=[np.inf] * 2, false_alarms=[1, 5])["lock_counts"]
    assert (counts["lost"], counts["early_alarms"]) == (1, 1)

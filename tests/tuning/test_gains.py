"""Tuning of gains: what may change, what is refused, what must be kept, and the same twice."""

import dataclasses
import math
from collections.abc import Sized
from typing import Any

import numpy as np
import pytest

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.words import design_from, words_of
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy
from sensorless.tuning.gains import search as searching
from sensorless.tuning.gains import verdict
from sensorless.tuning.gains.choice import FACTOR, OBSERVER, decode, gains_of, with_gains
from sensorless.tuning.gains.measure import (
    KEPT,
    Measured,
    cost,
    excess,
    measure,
    not_held_rate,
    pairs,
)
from sensorless.tuning.gains.record import record_of
from sensorless.tuning.gains.search import Search, judge, search
from tests.helpers.scenarios import lasting

PAPER = Motor.load("paper")
DESIGN = DriveDesign()
AT = derive(PAPER, DESIGN)
EQ25 = make_policy("eq25", PAPER)


def measured(lost: list[int], dev: float, **kept: float) -> Measured:
    """A drive with the same numbers in every scenario."""
    n = len(lost)
    numbers = {"torque_dev": dev, "torque_ripple": 0.0, "not_held": 0.0}
    numbers |= dict.fromkeys(KEPT, 1.0) | kept
    full = {name: np.full(n, x) for name, x in numbers.items()}
    return Measured(np.ones(n, dtype=bool), np.array(lost, dtype=bool), full)


@pytest.mark.parametrize("estimator", OBSERVER)
def test_every_gain_starts_at_the_machine_and_ends_within_its_range(estimator: str) -> None:
    design = DriveDesign(estimator=estimator)
    values = {**dataclasses.asdict(design), **dataclasses.asdict(derive(PAPER, design))}
    gains = gains_of(PAPER, design)
    assert {"speed_hz", *OBSERVER[estimator]} <= {gain.name for gain in gains}
    for x in (-9.0, -0.1, 0.0, 0.1, 9.0):
        for name, value in decode(gains, [x] * len(gains)).items():
            start = values[name]
            assert start / FACTOR * 0.999 <= value <= start * FACTOR * 1.001
            assert value == pytest.approx(start * math.exp(x), rel=1e-3) or abs(x) > 0.05
            with_gains(design, {name: value})  # refuses what is out of range


def test_what_the_user_sets_stays() -> None:
    names = [gain.name for gain in gains_of(PAPER, DESIGN, {"speed_hz", "mtpa"})]
    assert "speed_hz" not in names and "i_q_slew" in names
    with pytest.raises(UserError, match="leave two"):
        gains_of(PAPER, DESIGN, {*names[1:], "speed_hz"})


def test_the_words_make_the_tuned_drive() -> None:
    design = DriveDesign(estimator="flux", mtpa=False)
    tuned = with_gains(design, {"flux_gain": 0.1234, "speed_hz": 3.0})
    assert design_from(words_of(tuned)) == tuned
    assert words_of(DESIGN) == []


def test_a_gain_that_makes_the_twin_fail_loses() -> None:
    start, ours = measured([0, 0, 1, 1], 0.2), measured([0, 1, 0, 1], 0.1)
    ours.feasible[1] = False
    start.feasible[3] = False
    assert cost(ours, start).lost_rate == pytest.approx(1 / 3)
    assert cost(ours, start).torque_dev == pytest.approx(0.1)


def test_what_the_start_keeps_has_its_price() -> None:
    start = measured([0] * 4, 0.2)
    assert excess(start, start) == 0.0
    assert excess(start, start, margin=0.01) == pytest.approx(0.01 * len(KEPT))
    for name in KEPT:
        assert excess(measured([0] * 4, 0.1, **{name: 1.1}), start) == pytest.approx(0.1)
        assert excess(measured([0] * 4, 0.1, **{name: 0.9}), start) == 0.0
    loose = measured([0] * 4, 0.1)
    loose.numbers["not_held"][1:] = 1.0
    assert not_held_rate(loose, start) == 0.75 and excess(loose, start) == pytest.approx(7.5)
    saved = measured([1] * 4, 0.1)  # the start loses what now only swings
    assert excess(loose, saved) == 0.0


def test_a_cheaper_centre_that_settles_later_is_not_kept() -> None:
    start = measured([0] * 4, 0.2)
    known = Search(TWO, best_value=cost(start, start).objective)
    judge(known, {"speed_hz": 4.0}, measured([0] * 4, 0.1, settling=1.1), start)
    assert known.best == {} and [centre.unkept for centre in known.centres] == [pytest.approx(0.1)]
    judge(known, {"speed_hz": 3.0}, measured([0] * 4, 0.15), start)
    judge(known, {"speed_hz": 2.0}, measured([0] * 4, 0.17), start)
    assert known.best == {"speed_hz": 3.0} and known.best_value == pytest.approx(0.15)


def test_a_metric_is_compared_where_both_drives_survived_and_have_it() -> None:
    ours, start = measured([1, 0, 0, 0], 0.1, dip=2.0), measured([0, 1, 0, 0], 0.1, dip=1.0)
    start.numbers["dip"][3] = math.nan
    here, there = pairs("dip", ours, start)
    assert here.tolist() == [2.0] and there.tolist() == [1.0]


def bowl(motor: Motor, design: DriveDesign, policy: Policy, scenarios: Sized) -> Measured:
    """Costs least at a speed loop of 4 Hz and 250 A/s; SLOW settles late above 3 Hz."""
    speed, slew = design.speed_hz or AT.speed_hz, design.i_q_slew or AT.i_q_slew
    dev = math.log(speed / 4.0) ** 2 + math.log(slew / 250.0) ** 2
    kept = {"settling": 2.0 if speed > 3.0 else 1.0} if policy is SLOW else {}
    return measured([0] * len(scenarios), dev, **kept)


def counted(name: str, motor: Motor, seed: int, size: int, role: str) -> range:
    """In place of ``suite``: as many rows, of nothing."""
    return range(size)


SLOW = make_policy("eq25", PAPER)
TWO = [g for g in gains_of(PAPER, DESIGN) if g.name in ("speed_hz", "i_q_slew")]


def tuned(policy: Policy = EQ25, **changed: Any) -> Search:
    words = {"evaluations": 150, "size": 8, "seed": 5} | changed
    return search(PAPER, DESIGN, policy, TWO, **words)


def test_finds_the_least_and_keeps_what_the_start_keeps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(searching, "measure", bowl)
    monkeypatch.setattr(searching, "suite", counted)
    seen: list[float] = []
    found = tuned(progress=lambda done, best, start: seen.append(done))
    assert found.best == pytest.approx({"speed_hz": 4.0, "i_q_slew": 250.0}, rel=0.03)
    assert found.best_value < found.start_value and found.tried <= 150
    assert seen == sorted(seen) and len(seen) == found.tried
    kept = tuned(SLOW)
    assert kept.best["speed_hz"] <= 3.0
    assert record_of(PAPER, DESIGN, "eq25", found, 8, 5)["words"] == words_of(
        with_gains(DESIGN, found.best)
    )


def test_candidates_and_their_yardstick_run_the_same_scenarios(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each generation draws anew."""
    seen: dict[int, set[bool]] = {}

    def seeds(name: str, motor: Motor, seed: int, size: int, role: str) -> list[int]:
        return [seed] * size

    def noted(motor: Motor, design: DriveDesign, policy: Policy, scenarios: list[int]) -> Measured:
        seen.setdefault(scenarios[0], set()).add(design == DESIGN)
        return bowl(motor, design, policy, scenarios)

    monkeypatch.setattr(searching, "measure", noted)
    monkeypatch.setattr(searching, "suite", seeds)
    found = tuned(evaluations=30)
    generations = found.tried // found.population
    assert generations == 5 and len(seen) == 1 + generations, "one set more judges the centres"
    assert all(who == {True, False} for who in seen.values())


def test_ctrl_c_keeps_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0

    def until_tired(*args: Any) -> Measured:
        nonlocal calls
        calls += 1
        if calls == 60:
            raise KeyboardInterrupt
        return bowl(*args)

    monkeypatch.setattr(searching, "measure", until_tired)
    monkeypatch.setattr(searching, "suite", counted)
    found = tuned()
    assert found.interrupted and found.best and found.best_value < found.start_value


def test_the_same_seed_gives_the_same_gains_on_real_drives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(searching, "suite", lasting(0.05))
    monkeypatch.setattr(searching, "JUDGED", 1)
    first, second = (tuned(evaluations=6) for _ in range(2))
    assert first == second and first.tried == 6 and len(first.centres) == 1
    assert tuned(evaluations=6, seed=6).centres != first.centres


def test_a_measured_drive_is_the_one_that_was_asked_for() -> None:
    scenarios = lasting(0.05)("stress-1", PAPER, 4, 2, "tune")
    one, other = (measure(PAPER, DriveDesign(speed_hz=f), EQ25, scenarios) for f in (2.0, 6.0))
    assert not np.array_equal(one.numbers["torque_ripple"], other.numbers["torque_ripple"])


def test_too_little_is_refused() -> None:
    with pytest.raises(UserError, match="evaluations: 3; give 6"):
        tuned(evaluations=3)
    with pytest.raises(UserError, match="size: 7"):
        tuned(size=7)


@pytest.mark.parametrize(("spread", "told"), [(0.0, True), (0.5, False)])
def test_what_rose_beyond_chance_is_told(
    spread: float, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A settling time that is 5 % longer: in every scenario, or with 50 % more or less in each."""

    def run(motor: Motor, design: DriveDesign, policy: Policy, scenarios: Sized) -> Measured:
        found = measured([0] * len(scenarios), 0.2 if design == DESIGN else 0.1)
        if design != DESIGN:
            either = np.where(np.arange(len(scenarios)) % 2 == 0, spread, -spread)
            found.numbers["settling"][:] = 1.05 + either
        return found

    monkeypatch.setattr(verdict, "measure", run)
    monkeypatch.setattr(verdict, "suite", lambda name, motor, seed, size: range(size))
    monkeypatch.setattr(verdict, "SIZE", 80)
    facts = verdict.judged(PAPER, DESIGN, EQ25, Search(TWO, best={"speed_hz": 4.0}))
    assert facts["kept"]["settling"]["change"] == pytest.approx(0.05)
    assert ("settling +5.0 %" in facts["verdict"]) == told

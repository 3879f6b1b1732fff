"""The verdict about two schedules: right on made-up outcomes, and on drives that run."""

import json
import math

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation import compare as module
from sensorless.evaluation.compare import Outcomes, compare, comparison, outcomes
from sensorless.evaluation.objective import Cost
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

N = 400
RNG = np.random.default_rng(4)
DEV = 0.03 + 0.01 * RNG.standard_normal(N)
NONE, ALL = np.zeros(N, dtype=bool), np.ones(N, dtype=bool)


def ended(dev: np.ndarray[tuple[int], np.dtype[np.float64]], lost: int = 0) -> Outcomes:
    """Outcomes of which the first are lost."""
    gone = np.arange(N) < lost
    return Outcomes(ALL, gone, np.where(gone, 0.0, dev), np.where(gone, 0.0, 0.01))


def test_the_objective_of_many_draws_is_that_of_a_cost() -> None:
    some, rows = ended(DEV, lost=5), np.array([[0, 7, 7, 9], [10, 11, 12, 13], [0, 1, 2, 3]])
    want = [
        Cost(0.25, float(DEV[[7, 7, 9]].mean()), 0.01).objective,
        Cost(0.0, float(DEV[10:14].mean()), 0.01).objective,
        Cost(1.0, 1.0, 1.0).objective,
    ]
    np.testing.assert_allclose(some.objective(rows), want, rtol=1e-12)
    assert some.cost(ALL).lost_rate == 5 / N


@pytest.mark.parametrize(
    ("shift", "word"), [(-0.001, "better"), (0.001, "worse"), (0.0, "level"), (None, "same")]
)
def test_the_word_follows_the_interval(shift: float | None, word: str) -> None:
    """Noise of 0.4 % of torque in each pair, and a shift of 0.1 %: five standard errors."""
    noise = 0.004 * np.random.default_rng(5).standard_normal(N)
    ours = DEV if shift is None else DEV + shift + noise - noise.mean()
    found = comparison(ended(ours), ended(DEV), "the start")
    assert found.word == word and "the start" in found.sentence and "\n" not in found.sentence
    if shift is not None:
        low, high = found.interval
        base = float(DEV.mean()) + 0.01
        half = 1.96 * float(np.std(noise)) / math.sqrt(N) / base
        assert found.change == pytest.approx(shift / base, abs=1e-12)
        assert low == pytest.approx(found.change - half, abs=0.15 * half)
        assert high == pytest.approx(found.change + half, abs=0.15 * half)


def test_few_losses_more_are_no_proof() -> None:
    """One of 400 may be chance, thirty are not; both are said."""
    one, thirty = (comparison(ended(DEV, n), ended(DEV), "it") for n in (1, 30))
    assert (one.word, thirty.word) == ("level", "worse")
    assert "lost 30 instead of 0 of 400 scenarios" in thirty.sentence
    assert "rarer" not in thirty.sentence


def test_none_lost_does_not_mean_that_none_would_be() -> None:
    """With 95 % confidence the rate is at most 3 of 400."""
    found = comparison(ended(DEV - 0.001), ended(DEV), "it")
    assert found.word == "better"
    assert found.sentence.endswith(
        "that it was not made on, which may miss a loss rarer than 1 in 133"
    )


def test_what_is_not_feasible_does_not_count() -> None:
    ours, theirs = ended(DEV), ended(DEV + 0.01)
    half = Outcomes(np.arange(N) % 2 == 0, ours.lost, ours.torque_dev, ours.torque_ripple)
    found = comparison(half, theirs, "it")
    assert found.scenarios == N // 2
    assert "200 feasible scenarios (400 drawn) of stress-1" in found.sentence
    assert found.theirs.torque_dev == pytest.approx(float(DEV[::2].mean()) + 0.01)


def test_what_is_not_feasible_for_the_other_does_not_count_either() -> None:
    half = Outcomes(np.arange(N) % 2 == 0, NONE, DEV, DEV)
    assert comparison(ended(DEV), half, "it").scenarios == N // 2


def test_a_machine_that_can_do_nothing_is_not_judged() -> None:
    none = Outcomes(NONE, NONE, DEV, DEV)
    found = comparison(none, none, "it")
    assert found.word == "level" and found.sentence.startswith("not to compare with it")
    json.dumps(found.facts(), allow_nan=False)


def test_a_weight_that_moves_without_a_reason_is_told() -> None:
    """From 5 % of the feasible scenarios with a time of rest on."""
    shown = np.where(np.arange(N) < 200, np.arange(N) % 10 == 0, np.nan)
    feasible = np.arange(N) % 20 != 0
    ours = Outcomes(feasible, NONE, DEV + 0.001, DEV, shown)
    found = comparison(ours, ended(DEV), "it")
    assert found.hops == pytest.approx(10 / 190) and "k_s hops" in found.sentence
    both = comparison(ours, Outcomes(ALL, NONE, DEV, DEV, 0.9 * shown), "it")
    assert both.their_hops == pytest.approx(9 / 190) and "hops" not in both.sentence
    few = comparison(Outcomes(ALL, NONE, DEV + 0.001, DEV, 0.4 * shown), ended(DEV), "it")
    assert few.hops == pytest.approx(0.04) and "hops" not in few.sentence


def test_a_schedule_that_hops_on_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SIZE", 200)
    monkeypatch.setattr(module, "suite", suite)  # of their whole length
    motor = Motor.load("paper")
    eq25, fuzzy = (
        make_policy(word, motor) for word in ("eq25", "fuzzy:20.7258,320.825,0.309153,19.476")
    )
    found = compare(fuzzy, eq25, "Eq. 25", [SimFactory(motor, DriveDesign())])
    assert 0.1 < found.hops < 0.3 and "k_s hops" in found.sentence


def test_every_machine_has_scenarios_of_its_own() -> None:
    """Two that are the same machine here."""
    factory = SimFactory(Motor.load("paper"), DriveDesign())
    found = outcomes(make_policy("eq25", factory.motor), [factory] * 2, "stress-1", 97, 8)
    assert not np.any(found.torque_dev[:4] == found.torque_dev[4:])


def test_on_drives(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SIZE", 16)
    motor = Motor.load("paper")
    factories = [SimFactory(motor, DriveDesign())]
    eq25, half = (make_policy(word, motor) for word in ("eq25", "constant:0.5"))
    there, back = compare(half, eq25, "Eq. 25", factories), compare(eq25, half, "k", factories)
    assert (1.0 + there.change) * (1.0 + back.change) == pytest.approx(1.0)
    assert there.scenarios == 16 and there.theirs == back.ours
    assert compare(eq25, eq25, "Eq. 25", factories).word == "same"
    assert compare(half, eq25, "Eq. 25", factories).facts() == there.facts(), "repeatable"

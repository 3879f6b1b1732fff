"""Tuning: within its budget, reproducible, never worse than the start on what it judges by."""

import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from sensorless.baselines.linear import RULE
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import family, family_digest
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.objective import Cost
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, TablePolicy
from sensorless.tuning import rule_search
from sensorless.tuning import tune as tuning
from sensorless.tuning.judge import judged as judge
from sensorless.tuning.rule_search import generation_scenarios
from tests.helpers.scenarios import lasting

PAPER = Motor.load("paper")
DESIGN = DriveDesign()


def bowl(
    policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, *_: object
) -> tuple[list[Cost], float]:
    """Costs with their least at the band 0.15 to 0.6, without any drive."""
    out = []
    for policy in policies:
        assert isinstance(policy, TablePolicy)
        axis = policy.table.axes[0]
        out.append(Cost(0.0, (axis.lo - 0.15) ** 2 + (axis.hi - 0.6) ** 2, 0.0))
    return out, len(policies) * float(scenarios.duration.sum())


def none_near(
    policies: Sequence[Policy], scenarios: Scenarios, *_: object
) -> tuple[list[float], float]:
    """No near losses, in the time that they would take."""
    return [0.0] * len(policies), len(policies) * float(scenarios.duration.sum())


@pytest.fixture
def without_near_losses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule_search, "near_losses", none_near)


@pytest.mark.usefixtures("without_near_losses")
def test_finds_the_least_within_its_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rule_search, "costs", bowl)
    seen: list[float] = []
    found = tuning.tune(
        "linear", PAPER, DESIGN, 20000.0, 5, progress=lambda done, best: seen.append(done)
    )
    assert found.parameters == pytest.approx({"lo": 0.15, "hi": 0.6}, abs=0.02)
    known = found.provenance
    assert 0.5 * known["budget_s"] < known["used_s"] <= known["budget_s"]
    assert known["best"]["objective"] < known["start"]["objective"]
    assert known["policy"] == RULE.spec(found.parameters, PAPER)
    assert known["motor_digest"] == PAPER.digest
    assert seen == sorted(seen) and 0.9 < seen[-1] <= 1.0


def test_generations_draw_anew_and_centres_are_judged_on_one_set(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With half as many scenarios in which a load goes; all time simulated counts."""
    drawn: list[tuple[int, int, str]] = []
    candidates: list[int] = []
    times: list[float] = []

    def draw(
        motor: Motor, seed: int, generation: int, n: int, machine: int = 0, *, of: str = "stress-1"
    ) -> Scenarios:
        drawn.append((generation, n, of))
        return generation_scenarios(motor, seed, generation, n, machine, of=of)

    def found(*words: Any) -> tuple[list[Cost], float]:
        costs, time = bowl(*words)
        candidates.append(len(costs))
        times.append(time)
        return costs, time

    def near(*words: Any) -> tuple[list[float], float]:
        losses, time = none_near(*words)
        times.append(time)
        return losses, time

    for name, stub in (("generation_scenarios", draw), ("costs", found), ("near_losses", near)):
        monkeypatch.setattr(rule_search, name, stub)
    known = tuning.tune("linear", PAPER, DESIGN, 6000.0, 5).provenance
    whole, half = drawn[::2], drawn[1::2]
    assert {of for *_, of in whole} == {"stress-1"} and {of for *_, of in half} == {"unload"}
    assert [(g, n // 2) for g, n, _ in whole] == [(g, n) for g, n, _ in half]
    judged = {(g, n) for (g, n, _), k in zip(whole, candidates, strict=True) if k == 1}
    assert judged == {(0, known["scenarios_judged_on"])}
    tried = [g for (g, *_), k in zip(whole, candidates, strict=True) if k > 1]
    assert tried == list(range(1, known["generations"] + 1)) and len(tried) > 3
    assert known["used_s"] == pytest.approx(sum(times), abs=1e-3)


@pytest.mark.usefixtures("without_near_losses")
def test_one_parameter_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    def first_node(
        policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, *_: object
    ) -> tuple[list[Cost], float]:
        corners = [p.table.axes[0].hi for p in policies if isinstance(p, TablePolicy)]
        return [Cost(0.0, (c - 0.7) ** 2, 0.0) for c in corners], 16.0 * len(policies)

    monkeypatch.setattr(rule_search, "costs", first_node)
    found = tuning.tune("quadratic", PAPER, DESIGN, 5000.0, 1)
    assert found.parameters["corner"] == pytest.approx(0.7, abs=0.05)


@pytest.mark.usefixtures("without_near_losses")
def test_a_search_starts_from_the_numbers_given(monkeypatch: pytest.MonkeyPatch) -> None:
    """With numbers the first that is judged is they; with a budget for little else they stay."""
    judged: list[float] = []

    def first_node(
        policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, *_: object
    ) -> tuple[list[Cost], float]:
        corners = [p.table.axes[0].hi for p in policies if isinstance(p, TablePolicy)]
        judged.extend(corners)
        return [Cost(0.0, (c - 0.2) ** 2, 0.0) for c in corners], 16.0 * len(policies)

    monkeypatch.setattr(rule_search, "costs", first_node)
    found = tuning.tune("quadratic:300", PAPER, DESIGN, 5000.0, 1)
    assert judged[0] == pytest.approx(0.2)
    assert found.parameters["corner"] == pytest.approx(0.2)
    assert found.provenance["started_from"] == found.provenance["policy"] == "quadratic:300"
    verdict = judge(found, PAPER, DESIGN, 0, 1).provenance["verdict"]
    assert isinstance(verdict, dict) and "the same as its start" in verdict["verdict"]


@pytest.mark.usefixtures("without_near_losses")
def test_ctrl_c_keeps_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = 0

    def until_tired(
        policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, *_: object
    ) -> tuple[list[Cost], float]:
        nonlocal calls
        calls += 1
        if calls == 12:
            raise KeyboardInterrupt
        return bowl(policies, scenarios, factory)

    monkeypatch.setattr(rule_search, "costs", until_tired)
    known = tuning.tune("linear", PAPER, DESIGN, 20000.0, 5).provenance
    assert known["interrupted"] and known["generations"] == 8
    assert known["best"]["objective"] < known["start"]["objective"]


def test_near_losses_count_like_losses(monkeypatch: pytest.MonkeyPatch) -> None:
    """A band that comes near a loss in every hundredth scenario is not worth 0.1 of torque."""

    def near_from_half(
        policies: Sequence[Policy], scenarios: Scenarios, *_: object
    ) -> tuple[list[float], float]:
        ends = [p.table.axes[0].hi for p in policies if isinstance(p, TablePolicy)]
        time = len(policies) * float(scenarios.duration.sum())
        return [0.01 if hi > 0.5 else 0.0 for hi in ends], time

    monkeypatch.setattr(rule_search, "costs", bowl)
    monkeypatch.setattr(rule_search, "near_losses", near_from_half)
    found = tuning.tune("linear", PAPER, DESIGN, 20000.0, 5)
    assert 0.45 < found.parameters["hi"] <= 0.5
    best = found.provenance["best"]
    assert best["near_loss"] == 0.0
    assert best["objective"] == pytest.approx(best["torque_dev"])


def test_the_same_words_give_the_same_result_on_real_drives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tuning, "FEWEST_SCENARIOS", 2)
    monkeypatch.setattr(rule_search, "suite", lasting(0.1))
    state = np.random.get_state()[1].copy()  # type: ignore[index]
    first, second = (tuning.tune("linear", PAPER, DESIGN, 20.0, 7) for _ in range(2))
    assert first == second
    assert first.provenance["generations"] >= rule_search.CHECK
    third, fourth = (tuning.tune("linear", PAPER, DESIGN, 20.0, 7, machines=2) for _ in range(2))
    assert third == fourth
    assert third.provenance["start"] != first.provenance["start"]
    assert (np.random.get_state()[1] == state).all(), "leaves the global generator alone"  # type: ignore[index]


@pytest.mark.usefixtures("without_near_losses")
def test_random_machines_share_the_scenarios(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each machine has scenarios of its own; the mean over all is what is made least."""
    met: dict[str, list[Scenarios]] = {}

    def by_machine(
        policies: Sequence[Policy], scenarios: Scenarios, factory: SimFactory, *_: object
    ) -> tuple[list[Cost], float]:
        met.setdefault(factory.motor.name, []).append(scenarios)
        found, seconds = bowl(policies, scenarios, factory)
        shift = 0.3 * (list(met).index(factory.motor.name) - 1)  # cancels in the mean
        return [Cost(0.0, c.torque_dev + shift, 0.0) for c in found], seconds

    monkeypatch.setattr(rule_search, "costs", by_machine)
    found = tuning.tune("linear", PAPER, DESIGN, 20000.0, 5, machines=3)
    assert found.parameters == pytest.approx({"lo": 0.15, "hi": 0.6}, abs=0.02)
    known, motors = found.provenance, family(5, 3)
    assert list(met) == [motor.name for motor in motors]
    assert known["machines"]["digest"] == family_digest(motors)
    assert "motor_digest" not in known
    assert known["used_s"] <= known["budget_s"]
    assert known["best"]["objective"] < 0.01
    first = [parts[1] for parts in met.values()]
    assert len(np.unique(np.concatenate([s.seed for s in first]))) == sum(map(len, first))
    assert {len(s) for s in first} == {known["scenarios_per_candidate"] // 3}


def test_every_generation_has_scenarios_of_its_own() -> None:
    seeds = [rule_search.generation_scenarios(PAPER, 1, g, 8).seed for g in range(5)]
    others = rule_search.generation_scenarios(PAPER, 2, 1, 8).seed
    assert len(np.unique(np.concatenate([*seeds, others]))) == 48


@pytest.mark.parametrize(
    ("name", "budget", "said"),
    [
        ("nobody", 1e4, "gated"),
        ("eq25", 1e4, "no parameters"),
        ("linear:400,300", 1e4, "LO must be below HI"),
        ("linear", 10.0, "budget"),
        ("linear", float("nan"), "budget"),
        ("linear", float("inf"), "budget"),
    ],
)
def test_what_cannot_be_tuned_is_refused(name: str, budget: float, said: str) -> None:
    with pytest.raises(UserError, match=said):
        tuning.tune(name, PAPER, DESIGN, budget, 1)


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cma", None)
    with pytest.raises(UserError, match=r"sensorless\[tune\]"):
        tuning.tune("linear", PAPER, DESIGN, 1e4, 1)

"""Many policies at once cost what each costs alone."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import astuple
from typing import Any

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.aggregate import summary
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.objective import nearness
from sensorless.evaluation.rollout import Floats, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from sensorless.tuning.batch import SideBySide, costs, near_losses

pytestmark = pytest.mark.usefixtures("short_suites")

MOTOR = Motor.load("paper")
FACTORY = SimFactory(MOTOR, DriveDesign(estimator="smo"))
SCENARIOS = suite("stress-1", MOTOR, 4, 3, "tune")
SCENARIOS.duration[:] = 0.1


@pytest.mark.parametrize(
    "specs", [["eq25", "gated", "constant:0"], ["sliding_mode", "smo", "oracle"]]
)
def test_side_by_side_is_the_same_as_one_by_one(specs: list[str]) -> None:
    rows = np.tile(np.arange(3), len(specs))
    together = rollout(SideBySide([make_policy(s, MOTOR) for s in specs]), SCENARIOS[rows], FACTORY)
    for i, spec in enumerate(specs):
        alone = rollout(make_policy(spec, MOTOR), SCENARIOS, FACTORY)
        part = together.sums[:, 3 * i : 3 * (i + 1)]
        assert (part == alone.sums).all(), spec


def test_costs_do_not_depend_on_the_company(monkeypatch: pytest.MonkeyPatch) -> None:
    policies = [make_policy(s, MOTOR) for s in ("eq25", "hfi", "linear:100,900")]
    many, seconds = costs(policies, SCENARIOS, FACTORY)
    assert seconds == pytest.approx(0.9)
    for drives in (2, 3, 7):
        monkeypatch.setattr("sensorless.tuning.batch.DRIVES", drives)
        again, time = costs(policies, SCENARIOS, FACTORY)
        for one, other in zip(again, many, strict=True):  # sums of float64 in another order
            assert astuple(one) == pytest.approx(astuple(other), rel=1e-12)
        assert time == pytest.approx(seconds)


def test_the_cost_is_that_of_an_evaluation() -> None:
    scenarios = suite("stress-1", MOTOR, 0, 6, "tune")
    policy = make_policy("hysteresis:50,60", MOTOR)
    (cost,), _ = costs([policy], scenarios, FACTORY)
    scores = score(policy, scenarios, FACTORY)
    wanted = summary(scores.lost, scores.metrics, 0)
    assert 0.0 < cost.lost_rate < 1.0
    for name in ("lost_rate", "torque_dev", "torque_ripple"):
        key = name if name == "lost_rate" else f"{name}_rms"
        assert getattr(cost, name) == pytest.approx(wanted[key], rel=1e-6)
    parts = wanted["torque_dev_rms"] + wanted["torque_ripple_rms"]
    assert cost.objective == pytest.approx(10.0 * wanted["lost_rate"] + parts)


def test_a_loss_comes_near_from_10_to_90_degrees() -> None:
    assert nearness(np.radians([0.0, 10.0, 50.0, 90.0, 180.0])) == pytest.approx(
        [0.0, 0.0, 0.5, 1.0, 1.0]
    )


def test_near_losses_are_those_of_an_evaluation() -> None:
    """One rule that holds, one that loses some scenarios, in company and in pieces."""
    scenarios = suite("unload", MOTOR, 0, 6, "tune")
    policies = [make_policy(s, MOTOR) for s in ("hfi", "hysteresis:50,60")]
    found, seconds = near_losses(policies, scenarios, FACTORY)
    for policy, share in zip(policies, found, strict=True):
        scores = score(policy, scenarios, FACTORY)
        near = nearness(np.radians(scores.metrics["angle_err_max_deg"]))
        near = np.where(scores.lost != 0, 1.0, near)
        assert share == pytest.approx(float(near.mean()), abs=1e-6)
    assert found[0] < 0.01 < found[1]
    assert 0.0 < seconds <= 2 * float(scenarios.duration.sum())


class Found:
    """An engine that has run everything before it was asked."""

    def __init__(self, found: Floats) -> None:
        self.found = found

    def map(self, run: Callable[..., Any], jobs: Iterable[Any]) -> Iterator[Any]:
        return ((1.0, self.found) for _ in jobs)


def test_what_an_encoder_cannot_do_is_no_near_loss() -> None:
    """Three scenarios: lost, half way to a loss, lost and not feasible."""
    lost, feasible = [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]
    found = np.array([lost, feasible, [0.0] * 3, [0.0] * 3, np.radians([20.0, 50.0, 180.0])])
    engine = Found(found.reshape(5, 1, 3))
    near, _ = near_losses([make_policy("hfi", MOTOR)], SCENARIOS, FACTORY, engine)
    assert near == pytest.approx([(1.0 + 0.5) / 2.0])


def test_policies_with_gains_keep_their_own() -> None:
    nodes = np.zeros((2,), dtype=np.float32)
    tables = [
        KsTable((Axis("speed", 0.2, 0.3, 2),), 1.0 - nodes, gains=(GainGrid("l_q", nodes + v),))
        for v in (-0.5, 0.5)
    ]
    policies = [TablePolicy(f"{i}", table) for i, table in enumerate(tables)]
    together = rollout(SideBySide(policies), SCENARIOS[np.tile(np.arange(3), 2)], FACTORY)
    for i, policy in enumerate(policies):
        alone = rollout(policy, SCENARIOS, FACTORY)
        assert (together.sums[:, 3 * i : 3 * (i + 1)] == alone.sums).all()
    with pytest.raises(ValueError, match="different gains"):
        SideBySide([policies[0], make_policy("eq25", MOTOR)])


def test_rules_beside_a_schedule_that_sets_gains_cost_what_they_cost_alone() -> None:
    """As an export does, which compares its table with two thresholds."""
    nodes = np.zeros((2,), dtype=np.float32)
    table = KsTable((Axis("speed", 0.2, 0.3, 2),), 1.0 - nodes, gains=(GainGrid("l_q", nodes),))
    with_gains = TablePolicy("gains", table)
    policies = [with_gains, *(make_policy(s, MOTOR) for s in ("eq25", "hfi")), with_gains]
    mixed, _ = costs(policies, SCENARIOS, FACTORY)
    for policy, cost in zip(policies, mixed, strict=True):
        assert costs([policy], SCENARIOS, FACTORY)[0] == [cost]

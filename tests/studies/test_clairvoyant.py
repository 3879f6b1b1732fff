"""The clairvoyant bound: its weights, its search, and the share of the headroom."""

import json

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.frozen import FROZEN, MOTOR
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.helpers.script import script

STUDY = script("studies/clairvoyant.py")
PAPER = Motor.load(MOTOR)


def test_the_weight_is_a_run_plus_a_line_from_knot_to_knot() -> None:
    knots = np.array([[0.0, 0.5, 0.25], [1.0, 0.5, -0.5]])
    traces = np.full((11, 2), [0.25, 0.0])
    policy = STUDY.Moved(traces, knots, {}, 0.025)
    policy.reset(2)
    found = np.stack([policy.act(np.zeros((2, SIGNAL_N))) for _ in range(11)], axis=1)
    line = [0, 0.125, 0.25, 0.375, 0.5, 0.4375, 0.375, 0.3125, 0.25, 0.25, 0.25]
    assert found[0] == pytest.approx(0.25 + np.array(line))
    assert found[1, 4:9] == pytest.approx([0.5, 0.25, 0, 0, 0])


def test_the_search_begins_at_the_best_run_and_only_gets_better() -> None:
    factory, scenarios = SimFactory(PAPER, DriveDesign()), FROZEN[0].rows(PAPER)[8:10].draw()
    policies = [make_policy(name, PAPER) for name in ("hfi", "constant:0.9")]
    runs = [STUDY.errors(rollout(policy, scenarios, factory)) for policy in policies]
    best, history = STUDY.searched(policies, scenarios, factory, 2)
    costs = np.nan_to_num([x.sum(axis=0) for x in runs], nan=STUDY.LOST)
    assert history[0] == pytest.approx(costs.min(axis=0).mean())
    assert history[-1] < history[0] and history == sorted(history, reverse=True)
    assert best.sum(axis=0).mean() == pytest.approx(history[-1])


def test_a_run_again_with_its_own_weights_is_the_same() -> None:
    factory, scenarios = SimFactory(PAPER, DriveDesign()), FROZEN[0].rows(PAPER)[:3].draw()
    heard = STUDY.Heard(make_policy("sliding_mode", PAPER))
    run = rollout(heard, scenarios, factory)
    again = STUDY.Moved(np.stack(heard.asked), np.zeros((3, 2)), heard.settings, run.decision_time)
    assert np.array_equal(STUDY.errors(rollout(again, scenarios, factory)), STUDY.errors(run))


def test_the_share_of_the_headroom() -> None:
    rng = np.random.default_rng(1)
    bound = 0.5 + 0.5 * rng.random(400)
    base = bound + 0.5 + 0.2 * rng.random(400)
    half = 0.5 * (base + bound)
    whole = STUDY.share(half[None], base, bound)
    assert [whole["share"], *whole["share_ci"]] == pytest.approx([0.5, 0.5, 0.5])
    lost = np.where(np.arange(400) < 7, np.nan, bound)
    assert STUDY.share(lost[None], base, bound)["share"] == pytest.approx(1.0)
    noisy = half + 0.2 * rng.standard_normal(400)
    low, high = STUDY.share(noisy[None], base, bound)["share_ci"]
    assert low < 0.5 < high < low + 0.3
    seeds = np.stack([base, bound, base, bound])
    found = STUDY.share(seeds, base, bound)
    assert found["share"] == pytest.approx(0.5)
    assert found["share_ci"][1] - found["share_ci"][0] > 0.5, "four seeds tell little"


def test_the_record_is_of_the_frozen_suite() -> None:
    record = json.loads(STUDY.RECORD.read_text(encoding="utf-8"))
    assert set(record) == set(STUDY.EQ25)
    for estimator, entry in record.items():
        assert entry["digest"] == FROZEN[0].digest
        assert entry["after_generations"] == sorted(entry["after_generations"], reverse=True)
        assert entry["policies"][STUDY.EQ25[estimator]]["share"] == 0.0
        assert entry["size"] == len(entry["bound"][0])
        assert sum(map(np.mean, entry["bound"])) == pytest.approx(
            entry["after_generations"][-1], rel=1e-4
        )

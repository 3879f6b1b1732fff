"""The reward of ``Blend-v1``: bounds, and the order in which it puts known rules."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_v1 import GainEnv, GainVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.envs.reward import SCALE_TORQUE, TERMS
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.envs.window_reward import SCALE_RIPPLE, Window, WindowWeights, window_terms
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.metrics.step import overshoot_excess_pct
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

TUNED = Path(__file__).parents[2] / "results" / "reference" / "tuned"
RULES = ("eq25", str(TUNED / "logistic-tuned.json"), str(TUNED / "gated-tuned.json"))
SIZE = 32


def test_returns_rank_rules_as_the_published_metrics_do(motor: Motor) -> None:
    design = DriveDesign(estimator="smo")
    scenarios = suite("stress-1", motor, 3, SIZE)
    env = GainVectorEnv(SIZE, motor=motor, design=design, gains=())
    cost, deviation, ripple, overshoot = {}, {}, {}, {}
    kept = np.ones(SIZE, dtype=bool)  # a loss ends the metrics, so only where nobody loses
    for word in RULES:
        policy = make_policy(word, motor)
        run = rollout(policy, scenarios, SimFactory(motor, design))
        deviation[word], ripple[word] = torque_dev_rms(run), torque_ripple_rms(run)
        overshoot[word] = np.nan_to_num(overshoot_excess_pct(run))
        cost[word] = -returns(env, acts(policy, env), 0, scenarios)
        kept &= (run.lost == 0) & (cost[word] < WindowWeights().lost)
    assert kept.sum() > 0.9 * SIZE

    def best_first(score: dict[str, Any]) -> list[str]:
        return sorted(RULES, key=lambda word: float(score[word][kept].mean()))

    assert best_first(cost) == best_first(deviation) == best_first(ripple)
    assert best_first(cost) == best_first(overshoot)


def test_no_survivor_pays_as_much_as_a_loss(motor: Motor) -> None:
    """So losing lock early never pays; measured, as the bound of the terms is far from any run."""
    env = GainVectorEnv(SIZE, motor=motor, design=DriveDesign(estimator="smo"), gains=())
    earned = returns(env, acts(make_policy(RULES[2], motor), env), 5)
    weights = WindowWeights()
    assert earned[earned > -weights.lost].min() > -0.5 * weights.lost


def test_the_datasheet_states_the_bounds() -> None:
    weights = dataclasses.asdict(WindowWeights())
    lost = weights.pop("lost")
    text = GainEnv.__doc__ or ""
    assert f"at most {sum(weights.values()):.2f} per 1 ms, and lost_penalty (-{lost:g}" in " ".join(
        text.split()
    )


def test_a_cost_is_half_at_its_scale_over_the_whole_window(motor: Motor) -> None:
    window, sums = Window(1, 5e-3), np.zeros(1, dtype=SIM["sums"])
    sums["n"] = 25
    steady = SCALE_TORQUE * motor.tau_rated
    sums["tau"], sums["dev_sq"] = 25 * steady, 25 * steady**2
    for _ in range(7):
        window.add(sums)
    nobody = np.zeros(1, dtype=bool)
    parts = window_terms(window, sums, nobody, WindowWeights(), motor)
    assert tuple(parts) == TERMS
    assert parts["torque_deviation"][0] == pytest.approx(-0.5 * 0.05 * 5.0, rel=1e-5)
    assert parts["torque_ripple"][0] == pytest.approx(0.0, abs=1e-9)  # a constant one has none
    sums["tau"] = 0.0
    window.add(sums)
    parts = window_terms(window, sums, ~nobody, WindowWeights(), motor)
    assert parts["torque_ripple"][0] < -0.01 and parts["lost_penalty"][0] == -200.0


def earned(motor: Motor, **shares: float) -> dict[str, float]:
    """Terms of a decision of 25 periods, the first, with these sums per period."""
    window, sums = Window(1, 25 * motor.T_s), np.zeros(1, dtype=SIM["sums"])
    for name, share in {"n": 1.0, **shares}.items():
        sums[name] = 25 * share
    window.add(sums)
    parts = window_terms(window, sums, np.zeros(1, dtype=bool), WindowWeights(), motor)
    return {name: float(x[0]) for name, x in parts.items()}


def test_ripple_is_about_the_difference_to_the_twin(motor: Motor) -> None:
    """Both carry rated torque: what the drive's is off the twin's costs a half at its scale."""
    tau, off = motor.tau_rated, SCALE_RIPPLE * motor.tau_rated
    parts = earned(motor, tau=tau, tau_twin=tau, dev_sq=off**2)
    assert parts["torque_ripple"] == pytest.approx(-0.5 * 0.025 * 5.0, rel=1e-5)


@pytest.mark.parametrize(("off", "share"), [(0.05, 0.5), (-0.1, 0.8), (0.0, 0.0)])
def test_speed_off_the_twins_costs_a_half_at_5_percent(
    motor: Motor, off: float, share: float
) -> None:
    """x^2 / (x^2 + 0.05^2) of x, the difference over rated speed."""
    twin = 0.3 * motor.omega_m_rated
    parts = earned(motor, omega_m=twin + off * motor.omega_m_rated, omega_m_twin=twin)
    full = -WindowWeights().speed_deviation * 5.0
    assert parts["speed_deviation"] == pytest.approx(share * full, rel=1e-4, abs=1e-7)


def test_injection_costs_by_its_share_of_the_time(motor: Motor) -> None:
    full = -WindowWeights().injection * 5.0
    assert earned(motor, injecting=1.0)["injection"] == pytest.approx(full)
    assert earned(motor, injecting=0.2)["injection"] == pytest.approx(0.2 * full)


def test_movement_of_the_weight_costs_by_its_share_of_the_fastest(motor: Motor) -> None:
    full, fastest = -WindowWeights().activity * 5.0, DriveDesign.k_s_slew * motor.T_s
    for share in (0.5, 1.0):
        parts = earned(motor, k_s_moved=share * fastest)
        assert parts["activity"] == pytest.approx(share * full, rel=1e-5)


@pytest.mark.parametrize(("decision", "held"), [(1e-3, 20), (5e-3, 4), (0.02, 1), (0.05, 1)])
def test_the_window_holds_20_ms_and_at_least_a_decision(decision: float, held: int) -> None:
    window, sums = Window(1, decision), np.zeros(1, dtype=SIM["sums"])
    sums["dev_sq"] = 7.0
    window.add(sums)
    sums["dev_sq"] = 0.0
    found = []
    for _ in range(held):
        found.append(float(window.totals()["dev_sq"][0]))
        window.add(sums)
    assert found == [7.0] * held and window.totals()["dev_sq"][0] == 0.0


def test_the_window_forgets(motor: Motor) -> None:
    window, sums = Window(2, 5e-3), np.zeros(2, dtype=SIM["sums"])
    sums["n"], sums["dev_sq"] = 25, [25.0, 50.0]
    window.add(sums)
    window.clear(np.array([1]))
    assert window.totals()["dev_sq"].tolist() == [25.0, 0.0]
    sums["dev_sq"] = 0.0
    for _ in range(4):
        window.add(sums)
    assert window.totals()["dev_sq"].tolist() == [0.0, 0.0]

"""The state machine: who may go where, and when."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.baselines.gated import (
    DOWN,
    INJECTION,
    OBSERVER,
    RULE,
    UP,
    WAKE,
    WAKE_K_S,
    Gated,
)
from sensorless.machine.motor import Motor
from sensorless.policy import Signals

Make = Callable[..., Signals]


@pytest.fixture
def gated() -> Gated:
    policy = Gated(
        "gated",
        low=0.2,
        high=0.3,
        force=0.6,
        gate=0.5,
        release=1.0,
        hold=3e-3,
        ramp=4e-3,
        decision=1e-3,
    )
    policy.reset(1)
    return policy


def drive(policy: Gated, signals: Make, times: float = 1, **columns: float) -> list[int]:
    """States after each of some decisions at the same signals, warm unless told otherwise."""
    at = {"hf_amplitude": 1.0, "emf": columns.get("speed", 0.0), **columns}
    out = []
    for _ in range(int(times)):
        policy.act(signals(**at))
        out.append(int(policy.state[0]))
    return out


def test_goes_up_after_three_decisions_of_agreement(gated: Gated, signals: Make) -> None:
    assert drive(gated, signals, 4, speed=0.35) == [INJECTION, INJECTION, UP, UP]
    assert gated.act(signals(speed=0.35, hf_amplitude=1.0, emf=0.35))[0] == 0.25
    assert drive(gated, signals, 2, speed=0.35) == [UP, OBSERVER]


@pytest.mark.parametrize(
    "but", [{"disagreement": 0.6}, {"disagreement": -0.6}, {"emf": 0.1}, {"hf_amplitude": 0.1}]
)
def test_waits_while_they_disagree_or_one_is_cold(
    gated: Gated, signals: Make, but: dict[str, float]
) -> None:
    assert drive(gated, signals, 20, speed=0.35, **but) == [INJECTION] * 20
    assert drive(gated, signals, speed=0.6, **but) == [UP]


def test_one_disagreement_starts_the_count_again(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 2, speed=0.35)
    drive(gated, signals, 1, speed=0.35, disagreement=0.7)
    assert drive(gated, signals, 3, speed=0.35) == [INJECTION, INJECTION, UP]


def test_turns_around_when_it_goes_wrong(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 4, speed=0.35)
    assert drive(gated, signals, speed=0.35, disagreement=0.9) == [UP], "looser than the gate"
    assert drive(gated, signals, 4, speed=0.35, disagreement=1.1)[-1] == INJECTION


def test_the_way_back_wakes_the_injection_first(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 8, speed=0.7)
    assert gated.state[0] == OBSERVER
    assert drive(gated, signals, 2, speed=0.26) == [OBSERVER, OBSERVER]
    cold = gated.act(signals(speed=0.24, emf=0.24))
    assert gated.state[0] == WAKE and cold[0] == WAKE_K_S > 0.0
    assert drive(gated, signals, 1, speed=0.31) == [OBSERVER]
    assert drive(gated, signals, 5, speed=0.21) == [WAKE] * 5
    assert drive(gated, signals, 1, speed=0.19, disagreement=0.9) == [DOWN]
    assert drive(gated, signals, 4, speed=0.19)[-1] == INJECTION
    assert gated.act(signals(speed=0.19))[0] == 1.0


def test_a_cold_injection_is_waited_for(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 8, speed=0.7)
    drive(gated, signals, 2, speed=0.24, hf_amplitude=0.0)
    assert drive(gated, signals, 3, speed=0.19, hf_amplitude=0.0) == [WAKE] * 3
    assert drive(gated, signals, 3, speed=0.19, disagreement=0.9) == [WAKE, WAKE, DOWN]


def test_does_not_wait_for_agreement_near_standstill(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 8, speed=0.7)
    assert drive(gated, signals, 2, speed=0.1, disagreement=3.0) == [WAKE, DOWN]


def test_half_the_way_back_is_where_it_waits_no_longer(gated: Gated, signals: Make) -> None:
    drive(gated, signals, 8, speed=0.7)
    assert drive(gated, signals, 6, speed=0.11, disagreement=3.0) == [WAKE] * 6
    assert drive(gated, signals, 1, speed=0.1, disagreement=3.0) == [DOWN]


def test_agreement_counts_from_when_the_injection_is_awake(gated: Gated, signals: Make) -> None:
    """Before, on the observer, the idle injection's angle follows it."""
    drive(gated, signals, 8, speed=0.7)
    assert drive(gated, signals, 1, speed=0.24) == [WAKE]
    assert drive(gated, signals, 3, speed=0.19) == [WAKE, WAKE, DOWN]


def test_each_drive_has_its_own_state_and_nan_means_injection(signals: Make, gated: Gated) -> None:
    gated.reset(3)
    for _ in range(8):
        gated.act(signals(speed=[0.7, 0.1, 0.7], emf=1.0, hf_amplitude=1.0))
    assert gated.state.tolist() == [OBSERVER, INJECTION, OBSERVER]
    k_s = gated.act(signals(speed=[0.7, 0.1, np.nan], emf=1.0, hf_amplitude=1.0))
    assert k_s.tolist() == [0.0, 1.0, 1.0]


def test_milliseconds_become_decisions() -> None:
    policy = RULE.build("gated", {**RULE.defaults(), "hold": 7.0}, Motor.load("paper"))
    assert isinstance(policy, Gated)
    assert policy.hold == 7
    assert policy.step == pytest.approx(1.0 / 50.0)
    assert policy.gate == pytest.approx(0.5)


def test_times_stay_at_another_decision_period() -> None:
    policy = Gated("gated", low=0.2, high=0.3, force=0.6, gate=0.5, release=1.0, hold=30e-3,
                   ramp=40e-3, decision=1e-3)  # fmt: skip
    assert policy.hold == 30 and policy.step == pytest.approx(0.025)
    policy.follow(5e-3)
    assert policy.hold == 6 and policy.step == pytest.approx(0.125)

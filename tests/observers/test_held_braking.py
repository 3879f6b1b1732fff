"""A generator at low speed: what the coupled observer's gains owe to a held braking load."""

import math
from dataclasses import replace

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import designed
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.observers import flux_design, q_inductance, tracking
from sensorless.observers.coupled_design import bandwidths
from sensorless.observers.tracking import bandwidth, resistance_drift, voltage_drift
from sensorless.policies.registry import make_policy

LEANING = member(1_000_077, 42)
"""Its EMF leans by 0.8 at rated current, more than injection holds."""
LOW_R = member(1_000_077, 2)
"""Resistance takes 3 % of the EMF at rated speed."""


def lost(motor: Motor, size: int = 64) -> int:
    """Drives of ``braking`` that Eq. 25 loses."""
    designed.cache_clear()
    factory = SimFactory(motor, DriveDesign())
    found = score(make_policy("eq25", motor), suite("braking", motor, 1, size), factory)
    return int((found.lost != 0).sum())


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_shipped_machines_hold_it(name: str) -> None:
    assert lost(Motor.load(name)) == 0


def test_a_lean_that_injection_does_not_hold_needs_its_inductance_soon(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = lost(LEANING)
    monkeypatch.setattr(q_inductance, "BY_LEAN", 0.5)
    slow = lost(LEANING)
    designed.cache_clear()
    assert own == 0 and slow >= 2


def test_little_resistance_leaves_the_least_correction(monkeypatch: pytest.MonkeyPatch) -> None:
    least = 0.03 * LOW_R.omega_rated
    assert flux_design.standstill_rate(LOW_R) == pytest.approx(least)
    bound = 0.5 * LOW_R.R_s * (1.0 / LOW_R.L_d + 1.0 / LOW_R.L_q)
    assert bound < least
    paper = Motor.load("paper")
    assert flux_design.standstill_rate(paper) == pytest.approx(
        0.5 * paper.R_s * (1.0 / paper.L_d + 1.0 / paper.L_q)
    )


def test_injection_follows_the_larger_of_two_drifts() -> None:
    paper = Motor.load("paper")
    assert bandwidths(paper, 1.0).injection == bandwidth(paper, voltage_drift(paper))
    hot = replace(paper, R_s=8.0 * paper.R_s)
    assert resistance_drift(hot) == pytest.approx(hot.R_s * hot.i_rated / hot.psi_f / 3.0)
    assert 0.5 * resistance_drift(hot) > voltage_drift(hot)
    wide = bandwidths(hot, 1.0).injection
    assert wide == pytest.approx(bandwidth(hot, 1.0) * math.sqrt(0.5 * resistance_drift(hot)))
    assert q_inductance.rise_by_lean(hot) == q_inductance.rise_by_lean(paper)


def test_a_resistance_that_takes_the_voltage_wants_a_faster_injection(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """80 poles, 60 r/min, 48 V: rated current in R_s takes 45 % of the EMF at rated speed."""
    direct = Motor(
        name="direct", description="direct drive", n_p=40, R_s=0.4, L_d=1.2e-3, L_q=1.9e-3,
        psi_f=0.048731, J=0.05, B=0.063662, tau_rated=40.0, i_rated=13.859, n_rated_rpm=60.0,
        u_dc=48.0, T_s=1e-4, u_inj=9.6, i_max=20.789, i_trip=41.578, dead_time=5e-7,
        adc_range=27.719, adc_bits=12, saturation=Saturation.linear(1.2e-3, 1.9e-3, 0.048731),
    )  # fmt: skip

    def lost_of_mismatch() -> int:
        designed.cache_clear()
        factory = SimFactory(direct, DriveDesign())
        found = score(make_policy("eq25", direct), suite("mismatch", direct, 71, 128), factory)
        return int((found.lost != 0).sum())

    own = lost_of_mismatch()
    monkeypatch.setattr(tracking, "CHANGING", 0.0)
    slow = lost_of_mismatch()
    designed.cache_clear()
    assert own + 4 <= slow

"""The study of standstill: what it measures on traces that are known, and a run of it."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from sensorless.machine.motor import Motor
from tests.helpers.script import script

T_S = 2e-4


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return script("studies/standstill_study.py")


def test_torque_that_alternates_with_the_injection_does_not_count(study: ModuleType) -> None:
    t = T_S * np.arange(10_000)
    slow = 0.3 * np.sin(2.0 * np.pi * 5.0 * t)
    columns = {"t": t, "tau": slow + np.where(np.arange(len(t)) % 2, 0.2, -0.2)}
    columns["lost"] = np.zeros(len(t), dtype=np.int32)
    assert np.ptp(study.at_end(columns, "tau")) == pytest.approx(0.6, rel=1e-3)
    columns["lost"][-1] = 1
    assert np.isinf(np.ptp(study.at_end(columns, "tau")))


def test_only_the_end_counts_for_the_swing_and_all_for_the_dip(study: ModuleType) -> None:
    t = T_S * np.arange(10_000)
    columns = {"t": t, "omega_m": np.where(t < 0.5, -10.0, 0.0)}
    columns["lost"] = np.zeros(len(t), dtype=np.int32)
    assert np.ptp(study.at_end(columns, "omega_m")) == 0.0
    assert study.dip(columns, "omega_m") == pytest.approx(10.0 * 30.0 / np.pi)


def test_the_load_is_rated_torque(study: ModuleType) -> None:
    motor = Motor.load("ipmsm_2200w")
    s = study.scenario(motor, "impact", -1.0, 0.5, 3)
    assert s.tau[0, 0] == 0.0 and np.all(s.tau[0, 1:] == -motor.tau_rated)
    assert s.tau_rate[0, 0] == pytest.approx(motor.tau_rated / 0.002)
    assert s.J[0] == 0.5 and not s.omega.any()


def test_the_study_runs_on_any_motor_and_estimator(
    study: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "standstill.json"
    words = ["--motor", "ipmsm_2200w", "--estimator", "coupled", "--runs", "1", "--out", str(out)]
    monkeypatch.setattr(sys, "argv", ["standstill_study", *words])
    study.main()
    row = json.loads(out.read_text())["motors"]["ipmsm_2200w"]["coupled"]
    assert row["twin_dip_rpm"] < row["dip_rpm"] < 1.2 * row["twin_dip_rpm"]
    for inertia in ("J x 1", "J x 0.5"):
        assert row[inertia]["twin_torque_pct"] < row[inertia]["torque_pct"] < 4.0
        assert not row[inertia]["limit_cycle"]

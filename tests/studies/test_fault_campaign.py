"""The fault campaign: what a drive does with faulty sensors, link and interrupts."""

import json
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from sensorless.baselines.linear import eq25_band
from sensorless.core.api import ffi, lib, pointer
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from tests.helpers.script import script

SEEDS = range(101, 104)


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return script("studies/fault_campaign.py")


def test_without_a_fault_nothing_is_flagged(study: ModuleType, motor: Motor) -> None:
    plan = [study.Case("none", 0.0, 0.0), study.Case("gain", 1.0, 10.0)]
    for estimator in ("coupled", "flux"):
        end = study.run(motor, DriveDesign(estimator=estimator), plan, SEEDS)
        assert not end["fault"].any() and not end["lost"].any()
        assert np.all(end["k_flag"] == -1) and np.all(end["k_lost"] == -1)
        assert np.array_equal(end["i_peak"], end["i_unseen"])


def test_the_judge_compares_angles_of_one_instant(study: ModuleType) -> None:
    """Of the sample, not of a period later: at rated speed that is 3.6 degrees more."""
    motor = Motor.load("paper")
    plan = Scenarios.nominal(motor, np.zeros(1, dtype=np.uint64), 1.0)
    plan.omega[:] = motor.omega_rated / motor.n_p
    plan.omega_0 = plan.omega[:, 0].copy()
    s = SimFactory(motor, DriveDesign()).build(plan, twin=False)
    s["err_limit"] = np.deg2rad(2.5)
    faults, end = np.zeros(1, dtype=study.FAULTY), np.zeros(1, dtype=study.END)
    schedule = ffi.new("ks_schedule_params_t *")
    schedule.rule.x_min, schedule.rule.x_max = eq25_band(motor)
    schedule.periods = decision_periods(motor)
    lib.faulty_run(pointer(s, "sim_t[]"), 1, pointer(faults, "faulty_t[]"), schedule,
                   pointer(end, "faulty_end_t[]"))  # fmt: skip
    assert end["lost"][0] == 0


def test_what_a_limit_says_is_flagged_in_its_period(study: ModuleType, motor: Motor) -> None:
    """Samples and links beyond the machine's limits; the current ends with the bit."""
    plan = [study.Case("stuck", 2.0, 0.002), study.Case("link", 0.0, 0.002),
            study.Case("link", 3.0, 0.002)]  # fmt: skip
    end = study.run(motor, DriveDesign(), plan, SEEDS)
    assert np.all(end["k_flag"] == round(study.FROM / motor.T_s) + 1)
    assert np.all(end["fault"][0] & lib.FAULT_OVER_CURRENT)
    assert np.all(end["fault"][1:] & lib.FAULT_U_DC)
    assert np.all(end["i_peak"][0] < 0.98 * motor.adc_range)


def test_a_step_of_a_sensor_is_flagged_in_its_period(study: ModuleType, motor: Motor) -> None:
    """Half the converter's range on one channel, which no voltage brings about in a period."""
    plan = [study.Case("offset", -0.5, 0.2), study.Case("offset", -0.5, 10.0)]
    for estimator in ("coupled", "smo", "flux"):
        end = study.run(motor, DriveDesign(estimator=estimator), plan, range(101, 106))
        assert np.all(end["k_flag"] == round(study.FROM / motor.T_s) + 1)
        assert np.all(end["fault"] & lib.FAULT_CURRENT)


def test_a_trip_that_samples_do_not_show_is_passed_on(study: ModuleType, motor: Motor) -> None:
    """With nine of ten interrupts missed the hardware opens the bridge first."""
    end = study.run(motor, DriveDesign(), [study.Case("missed", 0.9, 10.0)], range(101, 102))[0]
    assert end["lost"][0] & lib.LOST_CURRENT
    assert end["k_flag"][0] <= end["k_lost"][0]
    assert end["fault"][0] & lib.FAULT_STOPPED
    frozen = study.run(motor, DriveDesign(), [study.Case("frozen", 0.0, 10.0)], SEEDS)[0]
    tripped = frozen["by_trip"] == 1
    assert tripped.any() and np.all(frozen["k_flag"][tripped] == frozen["k_lost"][tripped])


def test_interrupts_that_fail_are_told_where_the_emf_tells_nothing(study: ModuleType) -> None:
    """Voltage that acts when the drive does not think so turns or takes the injection's answer."""
    motor = Motor.load("ipmsm_2200w")
    faults = (("missed", 0.5), ("doubled", 0.5), ("late", 1.0), ("gain", 0.5))
    plan = [study.Case(kind, size, 0.2) for kind, size in faults]
    for estimator in ("coupled", "smo", "unwrapped"):
        end = study.run(motor, DriveDesign(estimator=estimator), plan, range(101, 106))
        gone = study.harmed(end, lib.LOST_ANGLE)
        assert gone.any() and not (gone & study.unseen(end, motor.T_s)).any()


def test_every_fault_leaves_numbers(study: ModuleType, motor: Motor) -> None:
    """The current stays below what a period beyond the trip can add; no state is damaged."""
    plan = [case for case in study.cases() if case.duration == 0.02]
    end = study.run(motor, DriveDesign(), plan, range(101, 102))
    rise = motor.u_dc * motor.T_s / motor.L_d
    assert np.all(np.isfinite(end["i_peak"])) and end["i_peak"].max() < motor.i_trip + 2.0 * rise
    assert not np.any(end["fault"] & lib.FAULT_STATE)


def test_the_study_writes_its_record(
    study: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "campaign.json"
    monkeypatch.setattr(study, "FAULTS", {"open": (0.0,), "late": (1.0,)})
    words = ["--estimator", "coupled", "--seeds", "2", "--out", str(out)]
    monkeypatch.setattr(sys, "argv", ["fault_campaign", *words])
    study.main()
    record = json.loads(out.read_text())["coupled"]
    assert record["scenarios"] == 2
    assert record["faults"]["open"]["cases"] == 2 * len(study.DURATIONS)
    late = record["faults"]["late"]
    assert 0 <= late["lost_untold"] <= late["lost_unseen"] <= late["lost"]

"""The error of a current sample that gains count on: a converter's step, or the sensor's noise."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import Scores, score
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.injection_signal import adc_step, sample_error
from sensorless.policies.registry import make_policy

PAPER = Motor.load("paper")


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_shipped_machines_count_on_a_step(name: str) -> None:
    assert sample_error(Motor.load(name)) == adc_step(Motor.load(name))


def test_a_finer_converter_makes_no_loop_faster() -> None:
    fine, finer = (replace(PAPER, adc_bits=bits) for bits in (14, 24))
    assert adc_step(finer) < 0.001 * adc_step(fine)
    assert derive(fine, DriveDesign()) == derive(finer, DriveDesign())
    records = [control_record(motor, DriveDesign()) for motor in (fine, finer)]
    loops = [name for name in records[0].dtype.names or () if name not in ("guard", "lock")]
    assert records[0][loops] == records[1][loops]  # bounds of tests follow the noise


def test_a_coarser_one_makes_them_slower() -> None:
    coarse = replace(PAPER, adc_bits=10)
    assert derive(coarse, DriveDesign()).hfi_pll_hz == pytest.approx(
        derive(PAPER, DriveDesign()).hfi_pll_hz * 0.25 ** (1.0 / 3.0)
    )


def test_a_finer_converter_makes_no_drive_worse() -> None:
    def run(motor: Motor) -> Scores:
        rows = SuiteRows("stress-1", motor, 1, 48).draw()
        return score(make_policy("eq25", motor), rows, SimFactory(motor, DriveDesign()))

    usual, finest = run(PAPER), run(replace(PAPER, adc_bits=18))
    assert not usual.lost.any() and not finest.lost.any()
    for name in ("torque_ripple_rms", "torque_dev_rms"):
        means = [np.mean(x.metrics[name]) for x in (finest, usual)]
        assert means[0] < 1.03 * means[1], name

"""The study of identification: its measure of inductances, and its summary."""

import dataclasses
import json
from pathlib import Path

import pytest

from sensorless.machine.motor import Motor, Saturation
from tests.helpers.script import script

ROOT = Path(__file__).parents[2]
MOTOR = Motor.load("ipmsm_2200w")
STUDY = script("studies/identify_study.py")


def test_errors_of_inductances_are_the_largest_ones() -> None:
    found = Saturation.linear(1.02 * MOTOR.L_d, 0.97 * MOTOR.L_q, MOTOR.psi_f)
    assert STUDY.inductance_errors(MOTOR, found) == pytest.approx((0.02, 0.03), rel=1e-3)
    bent = dataclasses.replace(found, a_qq=found.a_q0 / MOTOR.psi_f**2, T=2)
    assert STUDY.inductance_errors(MOTOR, bent)[1] > 0.1


def test_summary_counts_what_is_within_the_bars() -> None:
    good = dict.fromkeys((*STUDY.BARS, "gain", "R_s with the gain known"), 0.01)
    bad = good | {"R_s": -0.031}
    found = STUDY.summary([good, bad, {"refused": "why"}])
    assert (found["machines"], found["identified"], found["all within"]) == (3, 2, 1)
    assert found["R_s"]["within"] == 1 and found["R_s"]["worst"] == pytest.approx(0.031)


@pytest.mark.parametrize("name", ["identify", "identify-details", "identify-held-out"])
def test_the_record_says_what_its_machines_say(name: str) -> None:
    record = json.loads((ROOT / f"results/studies/{name}.json").read_text(encoding="utf-8"))
    again, there = STUDY.summary(record["machines"]), record["summary"]
    assert again.keys() == there.keys() and there["machines"] == 64
    for name, found in there.items():  # the record has six digits
        assert again[name] == pytest.approx(found, rel=1e-5), name

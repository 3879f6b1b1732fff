"""A report does not say yes where ``sensorless export`` says that the machine does not suit."""

from pathlib import Path

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.machine_check import Check
from sensorless.machine.motor import Motor
from sensorless.policies.bench import Bench
from sensorless.policy import Policy
from sensorless.report.report import Report
from sensorless.report.verdict import Verdict
from sensorless.suitability.examine import Examination
from sensorless.suitability.finding import NO, Finding

pytestmark = pytest.mark.usefixtures("short_suites")


def test_what_export_refuses_is_not_to_be_flashed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The check is of the drive of the page, here with settings that override; a *no* has none."""
    paper, asked = Motor.load("paper"), {"speed_hz": 4.0, "estimator": "smo"}
    loses = Finding(NO, "run", "the drive under the schedule loses 70% of reversal")
    checked = []

    def machine_with(policy: Policy, motor: Motor, design: DriveDesign) -> Check:
        checked.append((policy.name, motor, design.estimator, design.speed_hz))
        return Check(Examination(motor, (loses,)), ())

    monkeypatch.setattr("sensorless.report.judged.machine_with", machine_with)
    bench = Bench(paper, DriveDesign(estimator="smo", speed_hz=4.0), asked, override=True)
    report = Report("reference", bench, others=["eq25"])
    for first in (Verdict("yes", "Flash it."), Verdict("no", "Too few to judge by.")):
        monkeypatch.setattr("sensorless.report.report.verdict", lambda *_, v=first: v)
        written, said = report.write(tmp_path / first.word, ["nominal"], 1, 2, 2, "")
        assert said.word == "no" and said.head in written.read_text("utf-8")
        assert (loses.text in written.read_text("utf-8")) == (first.word == "yes")
    assert checked == [("reference", paper, "smo", 4.0)]

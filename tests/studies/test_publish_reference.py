"""What ``make reference`` leaves in the repository."""

import json
from pathlib import Path

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies
from tests.helpers.script import script

pytestmark = pytest.mark.usefixtures("short_suites")

STUDY = script("studies/publish_reference.py")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    motor = Motor.load("paper")
    for suite in ("stress-1", "handoff"):
        (folder / "report").mkdir(exist_ok=True)
        results = evaluate(
            motor, DriveDesign(), suite, 3, 6, make_policies(["eq25", "sensored"], motor)
        )
        results.write(folder / "report" / f"results-{suite}.json", scenarios=False)
    (folder / "tuned").mkdir()
    (folder / "tuned" / "linear-tuned.json").write_text("rule")
    for run in ("", "seed-1", "seed-2"):
        (folder / run).mkdir(exist_ok=True)
        for name in ("table.json", "config.json"):
            (folder / run / name).write_text(run)
        rows = "1,1,0.5,0.1,0.01,0.1\n2,2,0.4,0.1,0.01,0.1\n3,3,0.6,0.1,0.01,0.1\n"
        head = "steps,seconds,objective,lost_rate,torque_dev,torque_ripple\n"
        (folder / run / "progress.csv").write_text(head + rows)
    return folder


def test_tables_rules_and_one_page_are_published(made: Path, tmp_path: Path) -> None:
    STUDY.publish(made, tmp_path / "shipped", ["stress-1", "handoff"])
    found = {str(p.relative_to(tmp_path / "shipped")) for p in (tmp_path / "shipped").rglob("*.*")}
    best = {"table.json", "config.json", "progress.csv"}
    assert found == {
        "results.md",
        "runs.csv",
        "tuned/linear-tuned.json",
        *best,
    }
    lines = (tmp_path / "shipped" / "runs.csv").read_text().splitlines()
    assert [line.split(",")[0] for line in lines[1:]] == ["seed-1", "seed-2"]
    assert all(line.split(",")[1:4] == ["2", "2", "0.4"] for line in lines[1:])


def test_the_page_says_what_the_results_say(made: Path) -> None:
    results = json.loads((made / "report" / "results-handoff.json").read_text())
    row = next(x for x in STUDY.page([results]).splitlines() if x.startswith("| eq25"))
    deviation = 100.0 * results["policies"]["eq25"]["torque_dev_rms"]
    assert f"| {deviation:.2f} ±" in row
    assert "handoff" in STUDY.page([results])
